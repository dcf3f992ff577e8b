//! The clipping warning: which pixels of a picture are too bright to be shown, or black.

use crate::picture::ViewTransform;
use crate::preview::renderer::{NanMask, Picture};

/// The colour of pixels with a component that is brighter than the display can show.
pub(in crate::preview::app) const TOO_BRIGHT: u32 = 0x00ff_00c8;
/// The colour of pixels without any light.
pub(in crate::preview::app) const BLACK: u32 = 0x0000_48ff;

/// The picture with its clipped pixels marked. `view` is the transform that it was made with. While a slider is held,
/// there are no linear colours; then a component of 255 counts as too bright.
pub(super) fn marked(picture: &Picture, view: &ViewTransform) -> Picture {
    let factor = view.factor();
    // A little more than 1, so that what is just white does not count.
    let is_clipped = |component: f32| view.curve.at(f64::from(component.max(0.0)) * factor) > 1.0 + 1e-4;
    let mark = |pixel: u32, is_too_bright: bool| match pixel & 0x00ff_ffff {
        0 => BLACK,
        _ if is_too_bright => TOO_BRIGHT,
        colour => colour,
    };
    let pixels = match &picture.linear {
        Some(linear) => {
            let pairs = picture.pixels.iter().zip(&linear.linear);
            pairs.map(|(pixel, colour)| mark(*pixel, colour.iter().any(|component| is_clipped(*component)))).collect()
        }
        None => {
            let is_full = |pixel: u32| pixel.to_be_bytes()[1..].contains(&255);
            picture.pixels.iter().map(|pixel| mark(*pixel, is_full(*pixel))).collect()
        }
    };
    Picture { pixels, linear: None, nan: NanMask::default(), ..*picture }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Frame, ToneCurve, Transfer, quantise};
    use std::sync::Arc;

    fn picture(linear: Vec<[f32; 3]>, view: ViewTransform) -> Picture {
        let bytes = quantise(&linear, view);
        let pixels = bytes.chunks(3).map(|rgb| rgb.iter().fold(0, |word, byte| word << 8 | u32::from(*byte))).collect();
        let width = linear.len() as u32;
        let linear = Some(Arc::new(Frame { width, height: 1, linear }));
        Picture { width, height: 1, pixels, linear, ..Picture::default() }
    }

    #[test]
    fn pixels_that_are_too_bright_or_black_are_marked() {
        let colours = vec![[0.5, 0.2, 1.0], [0.5, 2.0, 0.1], [0.0; 3], [-1.0, 0.0, 0.0], [1.0; 3]];
        let plain = picture(colours.clone(), ViewTransform::default());
        let seen = marked(&plain, &ViewTransform::default());
        assert_eq!(seen.pixels, [plain.pixels[0], TOO_BRIGHT, BLACK, BLACK, plain.pixels[4]]);
        // One stop more clips what was above a half; Reinhard's curve clips nothing.
        let brighter = ViewTransform { exposure: 1.0, ..Transfer::Srgb.into() };
        assert_eq!(marked(&picture(colours.clone(), brighter), &brighter).pixels[0], TOO_BRIGHT);
        let soft = ViewTransform { curve: ToneCurve::Reinhard, ..brighter };
        let shown = picture(colours, soft);
        assert_eq!(marked(&shown, &soft).pixels[..2], shown.pixels[..2]);
    }

    #[test]
    fn without_linear_colours_a_full_component_counts() {
        let held = Picture { pixels: vec![0x0010_ff20, 0x0010_fe20], ..Picture::default() };
        assert_eq!(marked(&held, &ViewTransform::default()).pixels, [TOO_BRIGHT, 0x0010_fe20]);
    }
}
