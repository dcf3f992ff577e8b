//! Figures as SVG.

use crate::picture::{Bitmap, Format, bitmap_file_bytes};
use crate::plot::figure::{Anchor, Figure, FigureMark, Ink, Stroke};
use crate::plot::typeface::{SUBSCRIPT, SUBSCRIPT_DROP, SUBSCRIPT_SIZE};
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
            for (index, [x, y]) in thinned(points).iter().enumerate() {
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

/// The points without those that no eye misses (Douglas and Peucker 1973).
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    /// How far a line may be from a point that is left out.
    const TOLERANCE: f64 = 0.04;
    let mut kept = vec![false; points.len()];
    let mut ranges = vec![(0, points.len().saturating_sub(1))];
    while let Some((first, last)) = ranges.pop() {
        let (Some(from), Some(to)) = (points.get(first), points.get(last)) else { continue };
        (kept[first], kept[last]) = (true, true);
        let way = [to[0] - from[0], to[1] - from[1]];
        let squared = way[0] * way[0] + way[1] * way[1];
        let distance = |at: &[f64; 2]| {
            let off = [at[0] - from[0], at[1] - from[1]];
            let share = if squared > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
            (off[0] - share * way[0]).hypot(off[1] - share * way[1])
        };
        let between = (first + 1..last).map(|index| (index, distance(&points[index])));
        let farthest = between.max_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((index, _)) = farthest.filter(|(_, distance)| *distance > TOLERANCE) {
            ranges.extend([(first, index), (index, last)]);
        }
    }
    points.iter().zip(kept).filter_map(|(point, kept)| kept.then_some(*point)).collect()
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
    fn points_on_a_line_are_left_out() {
        let line: Vec<[f64; 2]> = (0..100).map(|index| [f64::from(index), 2.0 * f64::from(index)]).collect();
        assert_eq!(thinned(&line), [[0.0, 0.0], [99.0, 198.0]]);
        let corner = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.01], [10.0, 10.0]];
        assert_eq!(thinned(&corner), [[0.0, 0.0], [10.0, 0.01], [10.0, 10.0]]);
        // A closed way comes back to where it began.
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        assert_eq!((thinned(&square).len(), thinned(&[]).len(), thinned(&[[1.0, 2.0]]).len()), (4, 0, 1));
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
