//! The tests of every backend, on a graphics device. Without another one, Mesa's software device serves.

use crate::agreement::ONLY;
use illuminator::backends::gpu::Gpu;
use std::sync::Arc;

/// Runs a test of all backends for the device alone.
fn on_device(test: impl FnOnce()) {
    ONLY.set(Some(Arc::new(Gpu::default())));
    test();
    ONLY.set(None);
}

/// Tests of every backend that the device must pass too.
macro_rules! tests_of_every_backend {
    ($($module:ident: $($test:ident),+;)+) => {
        $(mod $module {
            $(#[test]
            fn $test() {
                super::on_device(super::super::$module::$test);
            })+
        })+
    };
}

tests_of_every_backend! {
    formulas: random_formulas_agree,
        powers_of_cosines_just_below_one_are_exact;
    drags: random_drags_give_the_general_picture;
    passes: both_backends_agree_in_every_pass,
        random_formulas_agree_in_every_pass,
        weights_of_rays_weigh_what_rays_see_of_the_environment,
        drags_of_passes_with_weights_of_rays_give_their_mean,
        random_drags_of_passes_give_their_mean,
        passes_one_by_one_and_all_at_once_give_the_same_bits;
    surface: glass_obeys_fresnel,
        places_on_surfaces_are_those_of_the_manual,
        mirrors_are_coloured_and_zero_cuts_exactly,
        ambient_light_and_emission_need_no_light,
        unbounded_weights_follow_the_recursion,
        backends_agree,
        random_terms_of_hits_agree;
    textures: colours_are_those_of_the_reference,
        drags_and_views_agree_with_the_interpreter,
        textures_are_replaced_while_a_slider_is_held;
    measured: pixels_have_the_reflectance_of_the_file;
    visible: light_comes_through_a_leaf_unless_something_is_behind_it,
        a_closed_body_hides_a_light_behind_it_by_its_far_side,
        without_shadow_rays_every_light_is_visible,
        only_ki_makes_a_term_exactly_zero,
        hits_of_any_formula_serve_any_other_with_the_same_bits,
        formulas_that_read_visible_are_dragged,
        backends_agree_where_many_lights_cast_many_shadows;
    choices: every_pair_takes_its_own_branches,
        more_choices_than_variants_are_right_too,
        formulas_that_choose_are_dragged;
    sessions: every_slider_is_dragged_by_its_method,
        pictures_are_right_within_any_budget,
        everything_is_prepared_again_when_other_numbers_change,
        scattered_hits_are_drawn_and_dragged,
        formulas_of_exponential_size_are_dragged,
        kept_work_follows_active_lights_and_path_weights;
}

/// A measured material is static or refused: kernels of the device have none.
#[test]
fn measured_materials_in_frames_are_refused() {
    use illuminator::engine::{Engine, Subject, Task};
    let scene = "bodies; b: sphere, center <0,0,0>, radius 1; lights; l: point, <3,4,5>;
        camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
    let picture = |formula: &str| {
        let view = illuminator::trace::View::new(8, 8).expect("within range");
        let subject = Subject::parse(&format!("body_specific; p: scalar; formula; {formula}"), scene, view).expect("a formula");
        let evaluator = Engine::new(Arc::new(Gpu::default())).evaluator(&subject, &[], &Task::UNWATCHED);
        evaluator.map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(picture("= IL*measured(\"x.bsdf\", R, V)*p;"), Ok(()));
    for formula in ["= measured(\"x.bsdf\", L + p*N, V);", "emission = measured(\"x.bsdf\", V + p*N, N); = IL;"] {
        let error = picture(formula).expect_err(formula);
        assert!(error.contains("the backend `gpu` cannot evaluate a measured material"), "{error}");
    }
}
