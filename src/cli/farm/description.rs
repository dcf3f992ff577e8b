//! What a job says, whatever it is written in.

/// What a job says.
pub(super) struct JobDescription {
    pub(super) name: String,
    pub(super) parts: u32,
    /// The program that workers run.
    pub(super) program: String,
    /// The arguments that all steps have.
    pub(super) arguments: Vec<String>,
    /// The folder that workers work in, which the paths among the arguments start from.
    pub(super) folder: String,
    /// Whether the file of the job is in this folder.
    pub(super) is_beside: bool,
}
