//! Comparing snapshots with the current picture and with each other.

use super::*;
use crate::lang::variables::Predefined;
use crate::preview::app::comparison::{GAINS, PAIRS, PaneMode};
use crate::workspace::OwnerId;
use egui_kittest::kittest::NodeT;

/// A picture with this much ambient light.
fn with_ambient(harness: &mut Harness<'_, App>, weight: f32) -> Vec<u32> {
    let workshop = &mut harness.state_mut().workshop;
    let ambient = workshop.formula().predefined(Predefined::Ambient);
    workshop.set(OwnerId::Global, ambient, [weight; 3]);
    settle(harness)
}

fn seen(harness: &Harness<'_, App>) -> Vec<u32> {
    let app = harness.state();
    app.pane.picture(&app.workshop).pixels.clone()
}

/// Chooses an entry of the menu, which closes.
fn choose(harness: &mut Harness<'_, App>, entry: &str) {
    harness.get_by_label("Compare").click();
    harness.run_steps(3);
    harness.get_by_label(entry).click();
    harness.run_steps(3);
}

#[test]
fn snapshots_are_compared_with_each_other_and_the_difference_is_told() {
    let mut harness = harness();
    let dark = with_ambient(&mut harness, 0.0);
    harness.state_mut().perform(Action::TakeSnapshot(0));
    // Until both are kept, they cannot be compared.
    harness.get_by_label("Compare").click();
    harness.run_steps(3);
    assert!(harness.get_by_label("A | B").accesskit_node().is_disabled());
    assert!(!harness.get_by_label("A | now").accesskit_node().is_disabled());
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    let light = with_ambient(&mut harness, 0.5);
    harness.state_mut().perform(Action::TakeSnapshot(1));
    let now = with_ambient(&mut harness, 1.0);
    assert!(dark != light && light != now);
    harness.get_by_label("Compare").click();
    harness.run_steps(3);
    harness.get_by_label("A | B").click();
    harness.run_steps(3);
    // Each row has the left half of A and the right half of B.
    let split = seen(&harness);
    let is_half = |row: usize| {
        split[64 * row..][..32] == dark[64 * row..][..32] && split[64 * row + 33..][..31] == light[64 * row + 33..][..31]
    };
    assert!((0..48).all(is_half));
    choose(&mut harness, "A − B");
    let byte = |word: u32, shift: u32| word >> shift & 0xff;
    let steps = |gain: u32| {
        let differ = |(a, b): (&u32, &u32)| {
            [16, 8, 0].iter().fold(0, |word, shift| word << 8 | (byte(*a, *shift).abs_diff(byte(*b, *shift)) * gain).min(255))
        };
        dark.iter().zip(&light).map(differ).collect::<Vec<u32>>()
    };
    assert!(seen(&harness) == steps(1));
    choose(&mut harness, "×16");
    assert!(seen(&harness) == steps(16));
    let largest = steps(1).iter().flat_map(|word| [16, 8, 0].map(|shift| byte(*word, shift))).max().expect("pixels");
    let app = harness.state();
    let words = app.pane.words_of_difference().expect("a difference in view");
    assert!(words.starts_with(&format!("Difference of A and B, amplified ×16; the largest is {largest} of 255")), "{words}");
}

#[test]
fn a_difference_follows_the_current_picture() {
    let mut harness = harness();
    harness.state_mut().perform(Action::TakeSnapshot(0));
    harness.state_mut().pane.mode = PaneMode::Difference(PAIRS[0], GAINS[0]);
    harness.run_steps(3);
    assert!(seen(&harness).iter().all(|word| *word == 0));
    assert_eq!(harness.state().pane.words_of_difference().as_deref(), Some("A and now are equal"));
    with_ambient(&mut harness, 1.0);
    harness.run_steps(3);
    assert!(seen(&harness).iter().any(|word| *word > 0));
    // Another session has no snapshots, so its picture is seen.
    harness.state_mut().perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    settle(&mut harness);
    harness.run_steps(3);
    let app = harness.state();
    assert!(app.pane.picture(&app.workshop).version == app.workshop.shown().version);
}
