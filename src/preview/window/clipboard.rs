//! The clipboard. If there is none, reading gives nothing and writing does nothing.

use crate::lang::lines::with_line_feeds;
use arboard::ImageData;
use egui::ColorImage;

/// The clipboard, opened when it is first used. Most sessions never use it.
#[derive(Default)]
pub(super) struct Clipboard {
    opened: Option<Option<arboard::Clipboard>>,
}

impl Clipboard {
    fn open(&mut self) -> Option<&mut arboard::Clipboard> {
        self.opened.get_or_insert_with(|| arboard::Clipboard::new().ok()).as_mut()
    }

    /// The text in the clipboard, with line feeds as line ends.
    pub(super) fn text(&mut self) -> Option<String> {
        let text = self.open()?.get_text().ok()?;
        Some(with_line_feeds(&text)).filter(|text| !text.is_empty())
    }

    pub(super) fn set_text(&mut self, text: String) {
        if let Some(clipboard) = self.open() {
            let _ = clipboard.set_text(text);
        }
    }

    pub(super) fn set_image(&mut self, image: &ColorImage) {
        let [width, height] = image.size;
        let bytes: Vec<u8> = image.pixels.iter().flat_map(egui::Color32::to_srgba_unmultiplied).collect();
        if let Some(clipboard) = self.open() {
            let _ = clipboard.set_image(ImageData { width, height, bytes: bytes.into() });
        }
    }
}
