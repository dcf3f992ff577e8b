use super::*;
use crate::preview::PictureView;
use egui::epaint::{ColorImage, ImageDelta, Mesh, Primitive, TextureId, Vertex, textures::TextureOptions};
use egui::{Color32, Pos2, Rect, pos2, vec2};
use proptest::prelude::*;

const GROUND: u32 = 0x0010_2030;

/// A painter with a texture of 4×4: the texel in the corner is white, the others are half transparent.
fn painter() -> Painter {
    let mut painter = Painter::new();
    set_texture(&mut painter, Color32::from_rgba_premultiplied(80, 60, 40, 128));
    painter
}

fn set_texture(painter: &mut Painter, texel: Color32) {
    let mut image = ColorImage::filled([4, 4], texel);
    image.pixels[0] = Color32::WHITE;
    let mut delta = TexturesDelta::default();
    delta.push(TextureId::default(), ImageDelta::full(image, TextureOptions::LINEAR));
    painter.update_textures(&mut delta);
    assert!(delta.is_empty());
}

fn clipped(clip_rect: Rect, mesh: Mesh) -> ClippedPrimitive {
    ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) }
}

fn triangle(corners: [(Pos2, Color32); 3]) -> Mesh {
    let vertices = corners.map(|(pos, color)| Vertex { pos, uv: Pos2::ZERO, color }).to_vec();
    Mesh { indices: vec![0, 1, 2], vertices, texture_id: TextureId::default() }
}

fn rectangle(rect: Rect, color: Color32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.add_colored_rect(rect, color);
    mesh
}

fn frame(size: [usize; 2], widgets: &[ClippedPrimitive]) -> PaintInput<'_> {
    PaintInput { size, scale: 1.0, background: GROUND, widgets, picture: None }
}

fn paint(size: [usize; 2], widgets: &[ClippedPrimitive]) -> Vec<u32> {
    let mut painter = painter();
    painter.paint(&frame(size, widgets));
    painter.pixels().to_vec()
}

#[test]
fn a_rectangle_has_the_pixels_whose_middles_are_in_it() {
    let rect = Rect::from_min_max(pos2(2.5, 3.4), pos2(70.5, 66.6));
    let pixels = paint([80, 70], &[clipped(Rect::EVERYTHING, rectangle(rect, Color32::from_rgb(255, 128, 1)))]);
    for (index, pixel) in pixels.iter().enumerate() {
        let middle = pos2((index % 80) as f32 + 0.5, (index / 80) as f32 + 0.5);
        let inside = middle.x >= rect.min.x && middle.x < rect.max.x && middle.y >= rect.min.y && middle.y < rect.max.y;
        assert_eq!(*pixel, if inside { 0x00ff_8001 } else { GROUND }, "{middle:?}");
    }
}

#[test]
fn a_triangle_has_the_colours_between_those_of_its_corners() {
    let corners = [pos2(3.0, 2.0), pos2(123.0, 22.0), pos2(43.0, 98.0)];
    let colours = [Color32::RED, Color32::GREEN, Color32::BLUE];
    let mesh = triangle([0, 1, 2].map(|at| (corners[at], colours[at])));
    let pixels = paint([128, 100], &[clipped(Rect::EVERYTHING, mesh)]);
    let area =
        |a: Pos2, b: Pos2, c: Pos2| f64::from(b.x - a.x) * f64::from(c.y - a.y) - f64::from(c.x - a.x) * f64::from(b.y - a.y);
    let bounds = area(corners[0], corners[1], corners[2]);
    for (index, pixel) in pixels.iter().enumerate() {
        let middle = pos2((index % 128) as f32 + 0.5, (index / 128) as f32 + 0.5);
        let [a, b, c] = corners;
        let parts = [area(middle, b, c), area(a, middle, c), area(a, b, middle)].map(|part| part / bounds);
        if parts.iter().any(|part| *part < -1e-6) {
            assert_eq!(*pixel, GROUND, "{middle:?}");
        } else if parts.iter().all(|part| *part > 1e-6) {
            let [blue, green, red, _] = pixel.to_le_bytes();
            for (part, channel) in parts.into_iter().zip([red, green, blue]) {
                assert!((part * 255.0 - f64::from(channel)).abs() < 0.51, "{middle:?}: {part} and {channel}");
            }
        }
    }
}

#[test]
fn triangles_that_share_a_border_neither_overlap_nor_leave_a_gap() {
    let half = Color32::from_rgba_premultiplied(0, 0, 0, 128);
    let hub = pos2(50.3, 47.9);
    let rim: Vec<Pos2> =
        (0..23).map(|step| hub + 60.0 * egui::Vec2::angled(step as f32 * std::f32::consts::TAU / 23.0)).collect();
    let mut mesh = Mesh::default();
    mesh.colored_vertex(hub, half);
    rim.iter().for_each(|at| mesh.colored_vertex(*at, half));
    (0..23).for_each(|step| mesh.add_triangle(0, 1 + step, 1 + (step + 1) % 23));
    let pixels = paint([100, 100], &[clipped(Rect::EVERYTHING, mesh)]);
    let once = colour::over(0x8000_0000, GROUND);
    let reach = 60.0 * (std::f32::consts::PI / 23.0).cos() - 1.0;
    for (index, pixel) in pixels.iter().enumerate() {
        let middle = pos2((index % 100) as f32 + 0.5, (index / 100) as f32 + 0.5);
        if middle.distance(hub) < reach {
            assert_eq!(*pixel, once, "{middle:?}");
        }
    }
}

#[test]
fn blending_is_the_nearest_to_exact_arithmetic() {
    for alpha in 0..=255_u32 {
        for below in 0..=255_u32 {
            let own = alpha / 3;
            let exact = f64::from(own) + f64::from(below) * f64::from(255 - alpha) / 255.0;
            let pixel = colour::over((alpha << 24) | (own * 0x0001_0101), below * 0x0001_0101);
            assert_eq!(pixel, (exact.round() as u32) * 0x0001_0101, "{alpha} on {below}");
        }
    }
    assert_eq!(colour::over(0x00ff_8040, 0x0001_8001), 0x00ff_ff41, "light that is added ends at white");
}

#[test]
fn texels_on_pixels_are_copied_and_others_are_between() {
    let rect = |left: f32| Rect::from_min_size(pos2(left, 5.0), vec2(4.0, 4.0));
    let mut exact = Mesh::default();
    exact.add_rect_with_uv(rect(5.0), Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
    let pixels = paint([16, 16], &[clipped(Rect::EVERYTHING, exact)]);
    assert_eq!(pixels[5 * 16 + 5], 0x00ff_ffff);
    assert_eq!(pixels[5 * 16 + 6], colour::over(0x8050_3c28, GROUND));
    assert_eq!(pixels[8 * 16 + 9], GROUND);

    let mut between = Mesh::default();
    between.add_rect_with_uv(rect(5.5), Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
    let pixels = paint([16, 16], &[clipped(Rect::EVERYTHING, between)]);
    // Halfway between the white texel and its neighbour: alpha is (255 + 128) / 2.
    let [_, _, red, _] = pixels[5 * 16 + 6].to_le_bytes();
    let exact = f64::midpoint(255.0, 80.0) + f64::from(0x10) * (1.0 - 191.5 / 255.0);
    assert!((f64::from(red) - exact).abs() < 1.5, "{red}, not {exact}");
}

#[test]
fn only_what_changed_is_drawn_again() {
    let mut painter = painter();
    let button = |color| clipped(Rect::EVERYTHING, rectangle(Rect::from_min_size(pos2(70.0, 70.0), vec2(20.0, 20.0)), color));
    let widgets = [button(Color32::RED)];
    let all = PixelRect { left: 0, top: 0, right: 300, bottom: 200 };
    assert_eq!(painter.paint(&frame([300, 200], &widgets)), [all]);
    assert_eq!(painter.paint(&frame([300, 200], &widgets)), []);
    let tile = PixelRect { left: 64, top: 64, right: 128, bottom: 128 };
    assert_eq!(painter.paint(&frame([300, 200], &[button(Color32::BLUE)])), [tile]);
    set_texture(&mut painter, Color32::BLACK);
    let letter = |painter: &mut Painter| {
        let mut mesh = Mesh::default();
        mesh.add_rect_with_uv(
            Rect::from_min_size(pos2(70.0, 70.0), vec2(4.0, 4.0)),
            Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)),
            Color32::RED,
        );
        painter.paint(&frame([300, 200], &[clipped(Rect::EVERYTHING, mesh)])).to_vec()
    };
    assert_eq!(letter(&mut painter), [tile]);
    assert_eq!(letter(&mut painter), []);
    set_texture(&mut painter, Color32::YELLOW);
    assert_eq!(letter(&mut painter), [tile], "the texture is another");
    assert_eq!(painter.paint(&frame([299, 200], &widgets)).len(), 1, "another size is another window");
    assert_eq!(painter.pixels().len(), 299 * 200);
}

fn view(pixels: &[u32], version: u64) -> PictureView<'_> {
    let pane = Rect::from_min_max(pos2(10.0, 20.0), pos2(90.0, 80.0));
    PictureView { pixels, width: 30, height: 20, version, pane, shown: [60, 40], offset: [4, -6], around: 0x0077_7777 }
}

#[test]
fn the_picture_lies_under_the_widgets_at_its_place() {
    let pixels: Vec<u32> = (0..600).collect();
    let menu = Rect::from_min_max(pos2(20.0, 0.0), pos2(40.0, 30.0));
    let widgets = [clipped(Rect::EVERYTHING, rectangle(menu, Color32::RED))];
    let mut painter = painter();
    painter.paint(&PaintInput { picture: Some(view(&pixels, 1)), ..frame([100, 90], &widgets) });
    for (index, pixel) in painter.pixels().iter().enumerate() {
        let [x, y] = [index % 100, index / 100];
        let expected = if (20..40).contains(&x) && y < 30 {
            0x00ff_0000
        } else if !(10..90).contains(&x) || !(20..80).contains(&y) {
            GROUND
        } else if (14..74).contains(&x) && y < 54 {
            ((x - 14) / 2 + (y - 14) / 2 * 30) as u32
        } else {
            0x0077_7777
        };
        assert_eq!(*pixel, expected, "{x}, {y}");
    }
    let other = vec![5; 600];
    assert_eq!(
        painter.paint(&PaintInput { picture: Some(view(&other, 1)), ..frame([100, 90], &widgets) }),
        [],
        "the version is the same"
    );
    assert!(!painter.paint(&PaintInput { picture: Some(view(&other, 2)), ..frame([100, 90], &widgets) }).is_empty());
    assert_eq!(painter.pixels()[40 * 100 + 50], 5);
    painter.paint(&frame([100, 90], &widgets));
    assert_eq!(painter.pixels()[40 * 100 + 50], GROUND, "the picture is gone");
}

#[test]
fn fewer_pixels_than_a_picture_says_are_none() {
    let mut painter = painter();
    painter.paint(&PaintInput { picture: Some(view(&[1, 2, 3], 1)), ..frame([100, 90], &[]) });
    assert!(painter.pixels().iter().all(|pixel| *pixel == GROUND));
}

/// The primitives that egui makes of a few widgets.
fn widgets(context: &egui::Context, painter: &mut Painter, scale: f32, typed: &str) -> Vec<ClippedPrimitive> {
    let mut input =
        egui::RawInput { screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(300.0, 200.0))), ..egui::RawInput::default() };
    input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = Some(scale);
    let mut output = context.run_ui(input, |ui| {
        ui.label(typed);
        let _ = ui.button("Apply formula");
        ui.add(egui::Slider::new(&mut 0.5, 0.0..=1.0));
    });
    painter.update_textures(&mut output.textures_delta);
    context.tessellate(output.shapes, output.pixels_per_point)
}

#[test]
fn what_egui_makes_is_painted_at_any_scale_and_not_again_unless_it_is_another() {
    for scale in [0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0] {
        let context = egui::Context::default();
        let mut painter = Painter::new();
        let size = [300.0, 200.0].map(|side: f32| (side * scale) as usize);
        let mut paint = |typed: &str| {
            let shown = widgets(&context, &mut painter, scale, typed);
            let changed = painter.paint(&PaintInput { scale, ..frame(size, &shown) }).len();
            (changed, painter.pixels().to_vec(), copies(&painter))
        };
        paint("kd = 1");
        let (_, first, copied) = paint("kd = 1");
        assert!(copied >= 15, "letters lie on pixels at {scale}: {copied}");
        let (changed, second, _) = paint("kd = 1");
        assert!(changed == 0 && first == second, "{scale}");
        let (changed, third, _) = paint("kd = 2");
        assert!(changed > 0 && first != third, "{scale}");
    }
}

fn copies(painter: &Painter) -> usize {
    painter.items.iter().filter(|item| matches!(item.content, Content::Copy { .. })).count()
}

/// Numbers that break arithmetic, and usual ones.
#[test]
fn a_scaled_picture_has_the_means_of_its_pixels_and_tiles_fit_together() {
    // Stripes of one row, shown at half their height and a third of their width, over several tiles.
    let pixels: Vec<u32> = (0..480 * 300).map(|at| if at / 480 % 2 == 0 { 0x00ff_0000 } else { 0x0000_00ff }).collect();
    let mut painter = painter();
    let pane = Rect::from_min_max(pos2(3.0, 5.0), pos2(200.0, 190.0));
    let picture =
        PictureView { pixels: &pixels, width: 480, height: 300, version: 1, pane, shown: [160, 150], offset: [7, 9], around: 1 };
    painter.paint(&PaintInput { picture: Some(picture), ..frame([210, 200], &[]) });
    for (index, pixel) in painter.pixels().iter().enumerate() {
        let [x, y] = [index % 210, index / 210];
        let inside = (10..170).contains(&x) && (14..164).contains(&y);
        let around = if (3..200).contains(&x) && (5..190).contains(&y) { 1 } else { GROUND };
        assert_eq!(*pixel, if inside { 0x0080_0080 } else { around }, "{x}, {y}");
    }
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -20.0_f32..220.0,
        4 => (-10_i32..200).prop_map(|bounds| bounds as f32),
        1 => prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e7, -1e7, f32::MAX, f32::MIN, f32::MIN_POSITIVE]),
    ]
}

fn colour() -> impl Strategy<Value = Color32> {
    prop_oneof![
        Just(Color32::WHITE),
        Just(Color32::TRANSPARENT),
        any::<[u8; 4]>().prop_map(|[r, g, b, a]| Color32::from_rgba_unmultiplied(r, g, b, a)),
        any::<[u8; 4]>().prop_map(|[r, g, b, a]| Color32::from_rgba_premultiplied(r, g, b, a)),
    ]
}

fn widget() -> impl Strategy<Value = ClippedPrimitive> {
    let point = || (number(), number()).prop_map(|(x, y)| pos2(x, y));
    let uv = prop_oneof![Just(Pos2::ZERO), (-0.5_f32..1.5, -0.5_f32..1.5).prop_map(|(x, y)| pos2(x, y)), point()];
    let vertex = (point(), uv, colour()).prop_map(|(pos, uv, color)| Vertex { pos, uv, color });
    let triangles = prop::collection::vec(vertex, 3..7).prop_map(|vertices| {
        let count = vertices.len() as u32;
        let indices = (0..2 * count).map(|at| (at * 5 + at / count) % (count + u32::from(at > 9))).collect();
        Mesh { indices, vertices, texture_id: TextureId::default() }
    });
    let rectangles = (point(), point(), point(), colour()).prop_map(|(a, b, uv, color)| {
        let mut mesh = Mesh::default();
        mesh.add_rect_with_uv(Rect::from_min_max(a, b), Rect::from_min_max(Pos2::ZERO, uv), color);
        mesh.add_colored_rect(Rect::from_two_pos(a, b), color);
        mesh
    });
    let clip = prop_oneof![Just(Rect::EVERYTHING), (point(), point()).prop_map(|(a, b)| Rect::from_min_max(a, b))];
    (clip, prop_oneof![triangles, rectangles]).prop_map(|(clip, mesh)| clipped(clip, mesh))
}

/// A step of a random session: whether the texture changes, the size, the scale, the widgets to keep, and those to
/// add.
type SessionStep = (Option<Color32>, [usize; 2], f32, u8, Vec<ClippedPrimitive>, Option<(u64, Rect, [u32; 2], [i32; 2])>);

fn step() -> impl Strategy<Value = SessionStep> {
    let size = prop_oneof![6 => Just([150, 140]), 1 => Just([1, 1]), 1 => Just([64, 65]), 1 => Just([0, 7])];
    let rect = (number(), number(), number(), number()).prop_map(|(a, b, c, d)| Rect::from_min_max(pos2(a, b), pos2(c, d)));
    let offset = prop::sample::select(vec![[0, 0], [-7, 12], [i32::MAX, i32::MIN], [40, -90]]);
    let shown = prop::sample::select(vec![[0, 0], [20, 15], [40, 30], [33, 25], [7, 90], [100_000_u32, 3]]);
    let picture = prop::option::of((0..3_u64, rect, shown, offset));
    let scale = prop::sample::select(vec![0.5, 1.0, 1.25, 3.0]);
    (prop::option::weighted(0.2, colour()), size, scale, any::<u8>(), prop::collection::vec(widget(), 0..4), picture)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_frame_is_what_painting_it_from_scratch_gives(steps in prop::collection::vec(step(), 1..6)) {
        let mut kept = painter();
        let mut texel = Color32::from_rgba_premultiplied(80, 60, 40, 128);
        let mut widgets: Vec<ClippedPrimitive> = Vec::new();
        for (texture, size, scale, keep, more, picture) in steps {
            if let Some(texture) = texture {
                texel = texture;
                set_texture(&mut kept, texel);
            }
            let mut number = 0;
            widgets.retain(|_| { number += 1; keep >> (number % 8) & 1 == 1 });
            widgets.extend(more);
            let pictures: Vec<Vec<u32>> = (0..3).map(|version| (0..20 * 15).map(|at| at * 999 + version).collect()).collect();
            let picture = picture.map(|(version, pane, shown, offset)| PictureView {
                pixels: &pictures[version as usize], width: 20, height: 15, version, pane, shown, offset, around: 0x0055_5555,
            });
            let frame = PaintInput { scale, picture, ..frame(size, &widgets) };
            let before = kept.pixels().to_vec();
            let changed = kept.paint(&frame).to_vec();
            let mut fresh = painter();
            set_texture(&mut fresh, texel);
            fresh.paint(&frame);
            prop_assert_eq!(kept.pixels(), fresh.pixels());
            if before.len() == kept.pixels().len() {
                for (at, (old, new)) in before.iter().zip(kept.pixels()).enumerate() {
                    let [x, y] = [(at % size[0]) as i32, (at / size[0]) as i32];
                    let told = changed.iter().filter(|rect| rect.contains(PixelRect { left: x, top: y, right: x + 1, bottom: y + 1 })).count();
                    prop_assert!(told <= 1 && (old == new || told == 1), "{x}, {y}: {old:x} became {new:x}, and is in {told} of {changed:?}");
                }
            }
        }
    }
}
