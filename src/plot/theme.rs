//! The colours of charts, on light and on dark paper.

/// On what paper a chart is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChartTheme {
    /// White paper.
    #[default]
    Light,
    /// Dark paper, for screens and slides.
    Dark,
}

/// The colours of curves, which those who see few colours can tell apart: Okabe and Ito (2008), "Color Universal
/// Design", without the yellow, which white paper swallows. Those for dark paper are lighter.
const CURVES: [[[u8; 3]; 7]; 2] = [
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [90, 90, 90]],
    [[86, 180, 233], [240, 130, 60], [40, 190, 150], [220, 150, 190], [240, 228, 66], [120, 150, 240], [190, 190, 190]],
];

/// How many curves have colours that differ, and differ from those of what stands beside curves.
pub const CURVE_COLOURS: usize = 6;

impl ChartTheme {
    fn pick<T>(self, light: T, dark: T) -> T {
        match self {
            ChartTheme::Light => light,
            ChartTheme::Dark => dark,
        }
    }

    /// The paper.
    pub fn paper(self) -> [u8; 3] {
        self.pick([255; 3], [24, 26, 30])
    }

    /// Titles.
    pub(super) fn text(self) -> [u8; 3] {
        self.pick([28, 30, 34], [236, 238, 242])
    }

    /// What is said beside: labels of ticks.
    pub fn muted(self) -> [u8; 3] {
        self.pick([92, 97, 105], [160, 166, 176])
    }

    /// Lines of the grid.
    pub fn grid(self) -> [u8; 3] {
        self.pick([226, 229, 233], [52, 56, 63])
    }

    /// Lines between those of the grid.
    pub(super) fn faint(self) -> [u8; 3] {
        self.pick([240, 242, 244], [38, 41, 47])
    }

    /// The lines around the area of a chart.
    pub fn frame(self) -> [u8; 3] {
        self.pick([140, 146, 154], [104, 110, 120])
    }

    /// Lines that warn: where more light leaves than comes.
    pub fn warning(self) -> [u8; 3] {
        self.pick([190, 40, 40], [250, 120, 110])
    }

    /// The colour of a curve. They repeat.
    pub fn curve(self, index: usize) -> [u8; 3] {
        let colours = &self.pick(CURVES[0], CURVES[1]);
        colours[index % colours.len()]
    }
}
