//! A drawing as data: paths, texts and images, each with its place. [`svg`](crate::plot::svg) and
//! [`painted`](crate::plot::painted) write it.

use crate::picture::Bitmap;
use crate::plot::typeface::width;

/// A colour and how much of it covers what is below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// The colour, red, green, blue, as 8-bit sRGB.
    pub colour: [u8; 3],
    /// From 0, nothing is seen, to 1, nothing below is seen.
    pub opacity: f64,
}

impl Ink {
    /// A colour that covers what is below.
    pub fn solid(colour: [u8; 3]) -> Self {
        Self { colour, opacity: 1.0 }
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width in units of the figure.
    pub width: f64,
    /// The lengths of dashes and gaps in turn; none is a solid line.
    pub dashes: Vec<f64>,
}

impl Stroke {
    /// A solid line.
    pub fn solid(colour: [u8; 3], width: f64) -> Self {
        Self { ink: Ink::solid(colour), width, dashes: Vec::new() }
    }
}

/// Where a text is, seen from its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// The middle of the text is there.
    Middle,
    /// The text ends there.
    End,
}

/// One thing that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum FigureMark {
    /// Straight lines through points.
    Path {
        /// The points, from left to right and downwards.
        points: Vec<[f64; 2]>,
        /// Whether the last point is joined to the first.
        closed: bool,
        /// What fills it.
        fill: Option<Ink>,
        /// The line along it.
        stroke: Option<Stroke>,
    },
    /// A line of text. It may have [subscripts](crate::plot::subscript).
    Text {
        /// Where it is: a point of its baseline.
        at: [f64; 2],
        /// Where the text is, seen from there.
        anchor: Anchor,
        /// Whether it is read upwards.
        upwards: bool,
        /// The size of the font.
        size: f64,
        /// Its colour.
        colour: [u8; 3],
        /// The text itself.
        text: String,
    },
    /// A picture.
    Image {
        /// Its top left corner.
        at: [f64; 2],
        /// Its width and height.
        size: [f64; 2],
        /// What it shows.
        bitmap: Bitmap,
        /// Whether its pixels blend into each other where it is enlarged.
        smooth: bool,
    },
}

/// The height of capital letters, in sizes of the font.
const CAPITALS: f64 = 0.72;

/// A drawing.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Width and height in units, which are pixels of a picture.
    pub size: [f64; 2],
    /// The colour behind everything.
    pub background: [u8; 3],
    /// What it says, for those who do not see it.
    pub title: String,
    /// What is drawn, from back to front.
    pub marks: Vec<FigureMark>,
}

impl FigureMark {
    /// The rectangle that a text takes: left, top, right and bottom. None for an empty text and for other marks.
    pub(super) fn text_rectangle(&self) -> Option<[f64; 4]> {
        let FigureMark::Text { text, at: [x, y], anchor, upwards, size, .. } = self else { return None };
        if text.is_empty() {
            return None;
        }
        let wide = width(text, *size);
        let from = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * wide,
            Anchor::End => -wide,
        };
        Some(match upwards {
            false => [x + from, y - CAPITALS * size, x + from + wide, *y],
            true => [x - CAPITALS * size, y - from - wide, *x, y - from],
        })
    }
}

/// The texts of a figure, each with its rectangle.
#[cfg(test)]
pub fn text_rectangles(figure: &Figure) -> Vec<(String, [f64; 4])> {
    let rectangle = |mark: &FigureMark| {
        let FigureMark::Text { text, .. } = mark else { return None };
        Some((crate::plot::typeface::plain(text), mark.text_rectangle()?))
    };
    figure.marks.iter().filter_map(rectangle).collect()
}

impl Figure {
    /// An empty drawing.
    pub fn new(size: [u32; 2], background: [u8; 3], title: &str) -> Self {
        Self { size: size.map(f64::from), background, title: title.to_owned(), marks: Vec::new() }
    }

    /// The same drawing, larger by a factor. Images keep their pixels.
    pub fn scaled(mut self, factor: f64) -> Self {
        let scale = |point: &mut [f64; 2]| point.iter_mut().for_each(|coordinate| *coordinate *= factor);
        scale(&mut self.size);
        for mark in &mut self.marks {
            match mark {
                FigureMark::Path { points, stroke, .. } => {
                    points.iter_mut().for_each(scale);
                    if let Some(stroke) = stroke {
                        stroke.width *= factor;
                        stroke.dashes.iter_mut().for_each(|length| *length *= factor);
                    }
                }
                FigureMark::Text { at, size, .. } => {
                    scale(at);
                    *size *= factor;
                }
                FigureMark::Image { at, size, .. } => {
                    scale(at);
                    scale(size);
                }
            }
        }
        self
    }

    /// Adds a line through points.
    pub fn line(&mut self, points: Vec<[f64; 2]>, stroke: Stroke) {
        self.marks.push(FigureMark::Path { points, closed: false, fill: None, stroke: Some(stroke) });
    }

    /// Adds a filled polygon.
    pub fn polygon(&mut self, points: Vec<[f64; 2]>, fill: Ink) {
        self.marks.push(FigureMark::Path { points, closed: true, fill: Some(fill), stroke: None });
    }

    /// Adds the outline of a rectangle with this corner and size.
    pub fn frame(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], stroke: Stroke) {
        let points = vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
        self.marks.push(FigureMark::Path { points, closed: true, fill: None, stroke: Some(stroke) });
    }

    /// Adds a text.
    pub fn text(&mut self, text: impl Into<String>, at: [f64; 2], anchor: Anchor, (size, colour): (f64, [u8; 3])) {
        self.marks.push(FigureMark::Text { at, anchor, upwards: false, size, colour, text: text.into() });
    }
}
