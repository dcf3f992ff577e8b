//! Figures as SVG.

use crate::picture::{Bitmap, Format, bitmap_file_bytes};
use crate::plot::figure::{Anchor, Figure, FigureMark, Ink, SUBSCRIPT, Stroke};
use crate::plot::typeface::{SUBSCRIPT_DROP, SUBSCRIPT_SIZE};
use std::fmt::Write;

/// The fonts that show texts, the built-in one first.
const FAMILY: &str = "Ubuntu, 'Noto Sans', 'DejaVu Sans', sans-serif";

/// The text of an SVG file. Texts stay texts, and pictures are in it as PNG.
pub fn svg(figure: &Figure) -> String {
    let [width, height] = figure.size;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"{FAMILY}\">\n<title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
        escaped(&figure.title),
        colour(figure.background)
    );
    for mark in &figure.marks {
        text.push_str(&element(mark));
        text.push('\n');
    }
    text.push_str("</svg>\n");
    text
}

/// A mark as an element.
fn element(mark: &FigureMark) -> String {
    match mark {
        FigureMark::Path { points, closed, fill, stroke } => {
            let mut data = String::new();
            for (index, [x, y]) in points.iter().enumerate() {
                let _ = write!(data, "{}{} {}", if index == 0 { "M" } else { "L" }, number(*x), number(*y));
            }
            let end = if *closed { "Z" } else { "" };
            let fill = fill.as_ref().map_or_else(|| " fill=\"none\"".to_owned(), |ink| painted_with("fill", ink));
            let stroke = stroke.as_ref().map(stroked).unwrap_or_default();
            format!("<path d=\"{data}{end}\"{fill}{stroke}/>")
        }
        FigureMark::Text { at: [x, y], anchor, upwards, size, colour: ink, text } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let (x, y) = (number(*x), number(*y));
            let turn = if *upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
            format!(
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{turn}>{}</text>",
                number(*size),
                colour(*ink),
                with_subscripts(text, *size)
            )
        }
        FigureMark::Image { at: [x, y], size: [width, height], bitmap, smooth } => {
            let rendering = if *smooth { "" } else { " style=\"image-rendering:pixelated\"" };
            format!(
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{rendering} \
                 href=\"data:image/png;base64,{}\"/>",
                number(*x),
                number(*y),
                number(*width),
                number(*height),
                base64(&png(bitmap))
            )
        }
    }
}

/// The bytes of a PNG file. It fails only for pictures with more pixels than the format has, which no chart has.
fn png(bitmap: &Bitmap) -> Vec<u8> {
    bitmap_file_bytes(bitmap, Format::Png).unwrap_or_default()
}

fn stroked(Stroke { ink, width, dashes }: &Stroke) -> String {
    let mut text = painted_with("stroke", ink);
    let _ = write!(text, " stroke-width=\"{}\" stroke-linejoin=\"round\"", number(*width));
    if dashes.is_empty() {
        text.push_str(" stroke-linecap=\"round\"");
    } else {
        let lengths: Vec<String> = dashes.iter().map(|length| number(*length)).collect();
        let _ = write!(text, " stroke-dasharray=\"{}\"", lengths.join(" "));
    }
    text
}

fn painted_with(what: &str, ink: &Ink) -> String {
    let opacity = if ink.opacity < 1.0 { format!(" {what}-opacity=\"{}\"", number(ink.opacity)) } else { String::new() };
    format!(" {what}=\"{}\"{opacity}", colour(ink.colour))
}

fn colour([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// A number with at most two digits behind the point.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// The text, where what is to be low has an element of its own.
fn with_subscripts(text: &str, size: f64) -> String {
    let mut pieces = text.split(SUBSCRIPT);
    let mut written = escaped(pieces.next().unwrap_or_default());
    for piece in pieces {
        let mut characters = piece.chars();
        let low = characters.next().map(String::from).unwrap_or_default();
        let drop = number(size * SUBSCRIPT_DROP);
        let _ = write!(written, "<tspan font-size=\"{}\" dy=\"{drop}\">{}</tspan>", number(size * SUBSCRIPT_SIZE), escaped(&low));
        let rest = escaped(characters.as_str());
        if !rest.is_empty() {
            let _ = write!(written, "<tspan dy=\"-{drop}\">{rest}</tspan>");
        }
    }
    written
}

/// Text as XML has it. Characters that XML 1.0 does not allow become spaces.
fn escaped(text: &str) -> String {
    let mut written = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '<' => written.push_str("&lt;"),
            '>' => written.push_str("&gt;"),
            '&' => written.push_str("&amp;"),
            '"' => written.push_str("&quot;"),
            character if character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}') => written.push(' '),
            character => written.push(character),
        }
    }
    written
}

/// Bytes as text (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |index: usize| u32::from(three.get(index).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place) & 63) as usize];
            text.push(if place > three.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        let pairs = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in pairs {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn texts_are_escaped() {
        let mut figure = Figure::new([10, 20], [255, 0, 16], "a <b> & \"c\"");
        figure.text(format!("θ{SUBSCRIPT}h<1\u{7}"), [1.0, 2.004], Anchor::Middle, (10.0, [0; 3]));
        let text = svg(&figure);
        assert!(text.contains("<title>a &lt;b&gt; &amp; &quot;c&quot;</title>") && text.contains("fill=\"#ff0010\""), "{text}");
        let run = "x=\"1\" y=\"2\" font-size=\"10\" text-anchor=\"middle\" fill=\"#000000\">\
            θ<tspan font-size=\"7.2\" dy=\"1.7\">h</tspan><tspan dy=\"-1.7\">&lt;1 </tspan></text>";
        assert!(text.contains(run), "{text}");
    }
}
