//! The two texts that are edited, each in a tab of its own.

use crate::workspace::FileKind;
use std::ops::{Index, IndexMut};

/// A tab.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TextTab {
    Formula,
    Scene,
}

impl TextTab {
    pub(super) const ALL: [TextTab; 2] = [TextTab::Formula, TextTab::Scene];

    /// The kind of text in it.
    pub(super) fn kind(self) -> FileKind {
        match self {
            TextTab::Formula => FileKind::Formula,
            TextTab::Scene => FileKind::Scene,
        }
    }

    /// The tab for texts of a kind; sessions and material libraries have none.
    pub(super) fn of(kind: FileKind) -> Option<TextTab> {
        TextTab::ALL.into_iter().find(|tab| tab.kind() == kind)
    }
}

/// One value for each tab.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct PerTab<T> {
    pub(super) formula: T,
    pub(super) scene: T,
}

impl<T> PerTab<T> {
    /// The values with their tabs, in the order of the tabs.
    pub(super) fn iter(&self) -> impl Iterator<Item = (TextTab, &T)> {
        TextTab::ALL.into_iter().map(|tab| (tab, &self[tab]))
    }

    /// The values in the order of the tabs.
    pub(super) fn values(&self) -> impl Iterator<Item = &T> {
        [&self.formula, &self.scene].into_iter()
    }

    /// What a function makes of each value.
    pub(super) fn map<U>(&self, mut function: impl FnMut(&T) -> U) -> PerTab<U> {
        PerTab { formula: function(&self.formula), scene: function(&self.scene) }
    }
}

impl<T> Index<TextTab> for PerTab<T> {
    type Output = T;

    fn index(&self, tab: TextTab) -> &T {
        match tab {
            TextTab::Formula => &self.formula,
            TextTab::Scene => &self.scene,
        }
    }
}

impl<T> IndexMut<TextTab> for PerTab<T> {
    fn index_mut(&mut self, tab: TextTab) -> &mut T {
        match tab {
            TextTab::Formula => &mut self.formula,
            TextTab::Scene => &mut self.scene,
        }
    }
}
