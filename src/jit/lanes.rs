//! What columns are made of.

/// Four records' values of one column, side by side in memory as kernels load them.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C, align(16))]
pub struct Lanes(pub [f32; 4]);

impl Lanes {
    /// How many records a block holds.
    pub const COUNT: usize = 4;

    /// The same value for all four records.
    pub fn splat(value: f32) -> Self {
        Self([value; 4])
    }

    /// The numbers of some blocks, one behind the other.
    pub fn flat(lanes: &[Lanes]) -> &[f32] {
        bytemuck::cast_slice(lanes)
    }

    /// How many blocks so many records take.
    pub fn blocks(records: usize) -> usize {
        records.div_ceil(Self::COUNT)
    }
}

/// A uniform value, in as many lanes as the widest kernels have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C, align(32))]
pub struct Splat([f32; 8]);

impl Splat {
    /// The value in all lanes.
    pub fn new(value: f32) -> Self {
        Self([value; 8])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_what_kernels_load() {
        assert_eq!((size_of::<Lanes>(), align_of::<Lanes>()), (16, 16));
        assert_eq!((size_of::<Splat>(), align_of::<Splat>()), (32, 32));
        assert_eq!(Lanes::blocks(0), 0);
        assert_eq!(Lanes::blocks(5), 2);
    }
}
