//! What the user can do with the instruments, beside choosing in their panel.

use crate::formula::ParameterId;
use crate::workspace::OwnerId;
use std::path::PathBuf;

/// An action on the instruments.
#[derive(Debug, Clone, PartialEq)]
pub enum InstrumentAction {
    /// Show the dialog that saves the chart.
    ShowSaveDialog,
    /// Save the chart, in the format of the suffix.
    Save(PathBuf),
    /// Show the dialog that chooses a measured material.
    ShowMeasuredDialog,
    /// Show the measured material in a file beside the formula.
    AddMeasured(PathBuf),
    /// Compare the picture with one that has this measured material on the body of the instruments.
    Compare(PathBuf),
    /// Show how much each pixel depends on a parameter of an owner; none to go back to the picture.
    ShowSensitivity(Option<(OwnerId, ParameterId)>),
}
