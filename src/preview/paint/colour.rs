//! Arithmetic with premultiplied colours, `0xAARRGGBB`, over opaque pixels, `0x00RRGGBB`.

/// `[red, green, blue, alpha]` as `0xAARRGGBB`.
pub(super) fn pack([red, green, blue, alpha]: [u8; 4]) -> u32 {
    u32::from_le_bytes([blue, green, red, alpha])
}

/// Two channels of a pair, each times a factor up to 255, divided by 255 and rounded.
fn scaled(pair: u32, factor: u32) -> u32 {
    let product = pair * factor + 0x0080_0080;
    ((product + ((product >> 8) & 0x00ff_00ff)) >> 8) & 0x00ff_00ff
}

/// A colour blended over a pixel. Colours that add light without hiding (with too small an alpha) are clamped to
/// white.
pub(super) fn over(colour: u32, below: u32) -> u32 {
    let through = 255 - (colour >> 24);
    let add = |own: u32, below: u32| {
        let sum = own + scaled(below, through);
        (sum | (((sum >> 8) & 0x0001_0001) * 0xff)) & 0x00ff_00ff
    };
    let outer = add(colour & 0x00ff_00ff, below & 0x00ff_00ff);
    let middle = add((colour >> 8) & 0xff, (below >> 8) & 0xff);
    outer | ((middle & 0xff) << 8)
}

/// The product of a texel and a colour, channel by channel.
pub(super) fn tinted(texel: u32, colour: u32) -> u32 {
    match (texel, colour) {
        (0, _) | (_, 0) => 0,
        (u32::MAX, _) => colour,
        (_, u32::MAX) => texel,
        _ => {
            let [a, b] = [texel.to_le_bytes(), colour.to_le_bytes()];
            let product = |channel: usize| {
                let product = u32::from(a[channel]) * u32::from(b[channel]) + 128;
                ((product + (product >> 8)) >> 8) as u8
            };
            u32::from_le_bytes([product(0), product(1), product(2), product(3)])
        }
    }
}

/// Blends a colour over a pixel.
pub(super) fn blend(pixel: &mut u32, colour: u32) {
    match colour >> 24 {
        0xff => *pixel = colour & 0x00ff_ffff,
        0 if colour == 0 => {}
        _ => *pixel = over(colour, *pixel),
    }
}

/// Blends a colour over a row of pixels.
pub(super) fn span(row: &mut [u32], colour: u32) {
    if colour >> 24 == 0xff {
        row.fill(colour & 0x00ff_ffff);
    } else {
        row.iter_mut().for_each(|pixel| *pixel = over(colour, *pixel));
    }
}
