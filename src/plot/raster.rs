//! Figures as pictures.

use crate::picture::Bitmap;
use crate::plot::figure::{Anchor, Figure, FigureMark, Ink, Stroke};
use crate::plot::typeface::{OutlinePiece, lay};
use tiny_skia::{
    Color, FillRule, FilterQuality, IntSize, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, StrokeDash,
    Transform,
};

/// The built-in font is light. A line around its letters, in parts of the size of the text, makes them regular.
const LETTER_LINE: f64 = 0.022;

/// The figure as a picture, one pixel for each unit.
///
/// # Errors
/// The figure has no size, or there is no memory for it. The text is a message for the user.
pub fn painted(figure: &Figure) -> Result<Bitmap, String> {
    let [width, height] = figure.size.map(|side| side.round().max(0.0) as u32);
    let mut canvas = Pixmap::new(width, height).ok_or_else(|| format!("a chart of {width}×{height} pixels cannot be painted"))?;
    let [red, green, blue] = figure.background;
    canvas.fill(Color::from_rgba8(red, green, blue, 255));
    for mark in &figure.marks {
        paint(&mut canvas, mark);
    }
    // Everything is painted on an opaque ground, so colours are not multiplied by anything.
    let bytes = canvas.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    Ok(Bitmap::of_bytes([width, height], bytes))
}

fn paint(canvas: &mut Pixmap, mark: &FigureMark) {
    match mark {
        FigureMark::Path { points, closed, fill, stroke } => {
            let Some(path) = polyline(points, *closed) else { return };
            if let Some(ink) = fill {
                canvas.fill_path(&path, &paint_of(ink), FillRule::EvenOdd, Transform::identity(), None);
            }
            if let Some(stroke) = stroke {
                canvas.stroke_path(&path, &paint_of(&stroke.ink), &stroke_of(stroke), Transform::identity(), None);
            }
        }
        FigureMark::Text { at, anchor, upwards, size, colour, text } => {
            let (letters, width) = lay(text, *size);
            let start = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5 * width,
                Anchor::End => -width,
            };
            let turn = if *upwards { -90.0 } else { 0.0 };
            let place = Transform::from_rotate(turn).post_translate(at[0] as f32, at[1] as f32);
            let ink = paint_of(&Ink::solid(*colour));
            let line = tiny_skia::Stroke { width: (size * LETTER_LINE) as f32, ..tiny_skia::Stroke::default() };
            for letter in letters {
                let Some(path) = outline(&letter.outline(), start) else { continue };
                canvas.fill_path(&path, &ink, FillRule::Winding, place, None);
                canvas.stroke_path(&path, &ink, &line, place, None);
            }
        }
        FigureMark::Image { at, size, bitmap, smooth } => {
            let [width, height] = bitmap.size();
            let rgba = bitmap.bytes().chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
            let Some(image) = IntSize::from_wh(width, height).and_then(|size| Pixmap::from_vec(rgba, size)) else { return };
            let scale = [size[0] / f64::from(width), size[1] / f64::from(height)].map(|scale| scale as f32);
            let place = Transform::from_scale(scale[0], scale[1]).post_translate(at[0] as f32, at[1] as f32);
            let quality = if *smooth { FilterQuality::Bilinear } else { FilterQuality::Nearest };
            let paint = PixmapPaint { quality, ..PixmapPaint::default() };
            canvas.draw_pixmap(0, 0, image.as_ref(), &paint, place, None);
        }
    }
}

fn polyline(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (index, [x, y]) in points.iter().map(|point| point.map(|number| number as f32)).enumerate() {
        if index == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

fn outline(pieces: &[OutlinePiece], start: f64) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let at = |[x, y]: [f64; 2]| [(x + start) as f32, y as f32];
    for (index, piece) in pieces.iter().enumerate() {
        match piece {
            OutlinePiece::Move(to) => {
                if index > 0 {
                    builder.close();
                }
                let [x, y] = at(*to);
                builder.move_to(x, y);
            }
            OutlinePiece::Line(to) => {
                let [x, y] = at(*to);
                builder.line_to(x, y);
            }
            OutlinePiece::Quad(control, to) => {
                let ([a, b], [x, y]) = (at(*control), at(*to));
                builder.quad_to(a, b, x, y);
            }
            OutlinePiece::Cubic(first, second, to) => {
                let ([a, b], [c, d], [x, y]) = (at(*first), at(*second), at(*to));
                builder.cubic_to(a, b, c, d, x, y);
            }
        }
    }
    builder.close();
    builder.finish()
}

fn paint_of(ink: &Ink) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    let [red, green, blue] = ink.colour;
    paint.set_color_rgba8(red, green, blue, (ink.opacity.clamp(0.0, 1.0) * 255.0).round() as u8);
    paint
}

fn stroke_of(stroke: &Stroke) -> tiny_skia::Stroke {
    let lengths = stroke.dashes.iter().map(|length| *length as f32).collect::<Vec<_>>();
    let dash = if lengths.is_empty() { None } else { StrokeDash::new(lengths, 0.0) };
    // A round end would make gaps shorter.
    let line_cap = if dash.is_some() { LineCap::Butt } else { LineCap::Round };
    tiny_skia::Stroke { width: stroke.width as f32, line_join: LineJoin::Round, line_cap, dash, ..tiny_skia::Stroke::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_and_images_are_where_they_are_said_to_be() {
        let mut figure = Figure::new([8, 4], [255; 3], "");
        figure.polygon(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 4.0], [0.0, 4.0]], Ink::solid([10, 20, 30]));
        let bitmap = Bitmap::filled(1, 1, [200, 100, 0]);
        figure.marks.push(FigureMark::Image { at: [4.0, 2.0], size: [2.0, 2.0], bitmap, smooth: false });
        let picture = painted(&figure).unwrap();
        let at = |x: usize, y: usize| &picture.bytes()[3 * (8 * y + x)..][..3];
        assert_eq!(picture.size(), [8, 4]);
        assert_eq!((at(0, 0), at(1, 3), at(2, 0)), (&[10, 20, 30][..], &[10, 20, 30][..], &[255; 3][..]));
        assert_eq!(
            (at(4, 2), at(5, 3), at(4, 1), at(6, 2)),
            (&[200, 100, 0][..], &[200, 100, 0][..], &[255; 3][..], &[255; 3][..])
        );
    }

    #[test]
    fn a_figure_without_a_size_is_refused() {
        assert!(painted(&Figure::new([0, 4], [255; 3], "")).is_err());
    }
}
