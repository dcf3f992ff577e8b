//! What is remarkable about a whole picture, in words: pixels without a number (NaN), a picture that is black, or one
//! in which every pixel has the same colour. Only causes that were found are named.

mod cause;
mod summary;
#[cfg(test)]
mod tests;

pub use cause::{PlainCause, UnlitReason};
pub use summary::PictureSummary;

use crate::evaluate::inspect::{Inspector, NanCause, NanOrigin, vector_figures};
use crate::formula::Formula;
use crate::picture::ViewTransform;
use crate::trace::View;
use crate::world::World;

/// What a picture was made of.
#[derive(Debug, Clone, Copy)]
pub struct ReviewedPicture<'p> {
    /// The formula.
    pub formula: &'p Formula,
    /// The world.
    pub world: &'p World,
    /// The view, in any pass.
    pub view: &'p View,
    /// How many passes the picture is the mean of, from the first one on.
    pub passes: u32,
    /// The parameter numbers, in the order of the [`Layout`](crate::formula::layout::Layout).
    pub numbers: &'p [f32],
    /// How linear colours become bytes.
    pub transform: ViewTransform,
}

/// Something remarkable about a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum PictureFinding {
    /// Pixels with a component that is NaN.
    Undefined {
        /// How many there are.
        count: usize,
        /// How many pixels the picture has.
        pixels: usize,
        /// The first of them: column and row from the top left.
        first: [u32; 2],
        /// The first pass in which that pixel has a NaN, if the picture is the mean of several.
        pass: Option<u32>,
        /// Where the NaN of the first one comes from, in words.
        origin: String,
    },
    /// Every pixel is black.
    Black(PlainCause),
    /// Every pixel has the same colour, linear RGB.
    OneColour([f32; 3], PlainCause),
}

impl PictureFinding {
    /// The finding as one sentence without a full stop.
    pub fn message(&self) -> String {
        match self {
            PictureFinding::Undefined { count, pixels, first: [x, y], pass, origin } => {
                let place = match count {
                    1 => format!("in 1 pixel, ({x}, {y}),"),
                    _ if count == pixels => "in every pixel".to_owned(),
                    _ => format!("in {count} pixels"),
                };
                let pass = pass.map(|pass| format!("pass {pass}"));
                let pixel = (*count > 1).then(|| format!("({x}, {y})"));
                let which = match (pixel, pass) {
                    (None, None) => String::new(),
                    (Some(one), None) | (None, Some(one)) => format!("in {one} "),
                    (Some(pixel), Some(pass)) => format!("in {pixel}, {pass}, "),
                };
                format!("{place} the formula gives no number (NaN), which is shown as 0: {which}{origin}")
            }
            PictureFinding::Black(cause) => format!("the picture is black: {cause}"),
            PictureFinding::OneColour(colour, cause) => {
                format!("every pixel has the same colour, {}: {cause}", vector_figures(colour.map(f64::from)))
            }
        }
    }

    /// A pixel in which the cause can be seen, and the pass if there are several.
    pub fn pixel(&self) -> Option<([u32; 2], Option<u32>)> {
        match self {
            PictureFinding::Undefined { first, pass, .. } => Some((*first, *pass)),
            PictureFinding::Black(_) | PictureFinding::OneColour(..) => None,
        }
    }
}

/// What is remarkable about a picture with this summary. This takes some milliseconds if the picture is black, and next
/// to nothing if nothing is remarkable.
pub fn review(picture: &ReviewedPicture, summary: &PictureSummary) -> Option<PictureFinding> {
    if let Some(first) = summary.first_nan {
        let width = picture.view.width() as usize;
        let first = [first % width, first / width].map(|coordinate| coordinate as u32);
        let (pass, origin) = nan_origin(picture, first);
        return Some(PictureFinding::Undefined { count: summary.nan, pixels: summary.pixels, first, pass, origin });
    }
    if summary.is_black(&picture.transform) {
        return Some(PictureFinding::Black(cause::of_black(picture, summary)));
    }
    // One pixel always has one colour.
    let colour = summary.only_colour.filter(|_| summary.pixels > 1)?;
    Some(PictureFinding::OneColour(colour, cause::of_one_colour(picture)))
}

/// Where the NaN of a pixel comes from, in words, and in which pass if there are several.
fn nan_origin(picture: &ReviewedPicture, pixel: [u32; 2]) -> (Option<u32>, String) {
    let inspector = Inspector::new(picture.formula, picture.world, picture.numbers);
    let several = picture.passes > 1;
    let passes = if several { 0..picture.passes } else { picture.view.pass()..picture.view.pass() + 1 };
    // Whether red, green and blue were infinite in a pass, of each sign.
    let mut infinite = [[false; 2]; 3];
    for pass in passes {
        let Some(inspection) = inspector.inspect(&picture.view.with_pass(pass), pixel) else { break };
        if inspection.total.iter().any(|component| component.is_nan()) {
            return (several.then_some(pass), cause_in_words(picture.world, inspector.nan_cause(&inspection)));
        }
        for (seen, component) in infinite.iter_mut().zip(inspection.total) {
            seen[0] |= component == f32::NEG_INFINITY;
            seen[1] |= component == f32::INFINITY;
        }
    }
    if infinite.contains(&[true; 2]) {
        return (None, cause_in_words(picture.world, Some(NanCause::BothSigns)));
    }
    (None, "the interpreter gives a number there".to_owned())
}

fn cause_in_words(world: &World, cause: Option<NanCause>) -> String {
    match cause {
        Some(NanCause::Expression(origin)) => origin_in_words(world, &origin),
        Some(NanCause::InfiniteTimesZero(body)) => {
            format!("an infinite number is multiplied by a weight of 0 on {}", world.scene().body(body).name)
        }
        Some(NanCause::BothSigns) => "infinite numbers of both signs are added up".to_owned(),
        None => "no cause was found".to_owned(),
    }
}

fn origin_in_words(world: &World, NanOrigin { body, light, typed_in, written, numbers }: &NanOrigin) -> String {
    /// Longer expressions are cut.
    const MOST: usize = 48;
    let cut = |text: &str| match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    };
    let body = &world.scene().body(*body).name;
    let light = light.map_or_else(String::new, |light| format!(" for light {}", world.scene().light(light).name));
    let with_numbers = if written == numbers { String::new() } else { format!(", with numbers `{}`,", cut(numbers)) };
    let place = typed_in.as_ref().map_or_else(String::new, |name| format!(" of {name}"));
    format!("it is `{}`{place}{with_numbers} on {body}{light}", cut(written))
}
