//! Charts of a fit: the data beside the formula before and after.

use crate::fit::request::{FittedOwners, difference};
use crate::formula::Formula;
use crate::instrument::Reflectance;
use crate::instrument::model::{FormulaModel, ModelProgram, Place};
use crate::instrument::view::{InstrumentView, NamedModel, ViewSettings};
use crate::measured::MeasuredMaterial;
use crate::picture::Frame;
use crate::plot::{Chart, ChartAxis, ChartHeading, MapChart, MapPanel, MapValues};
use crate::workspace::Values;
use std::sync::Arc;

/// Balls of a formula with the values before and after, beside the material if one was measured.
pub fn of_models(
    formula: &Formula,
    [before, after]: [&Values; 2],
    owners: FittedOwners,
    measured: Option<&Arc<MeasuredMaterial>>,
    described: &str,
) -> Chart {
    let program = Arc::new(ModelProgram::new(formula));
    let of = |name: &str, values: &Values| {
        let numbers = values.of_surface(formula, [owners.body, owners.light]);
        let model: Arc<dyn Reflectance> = Arc::new(FormulaModel::new(Arc::clone(&program), numbers, Place::default()));
        NamedModel { name: name.to_owned(), model }
    };
    let mut models = vec![of("before", before), of("after", after)];
    if let Some(material) = measured {
        let model: Arc<dyn Reflectance> = Arc::clone(material) as _;
        models.insert(0, NamedModel { name: "measured".to_owned(), model });
    }
    let settings = ViewSettings { subtitle: described.to_owned(), ..ViewSettings::default() };
    match InstrumentView::named("sphere") {
        Some(view) => view.chart(&models, &settings),
        None => Chart::Map(MapChart::default()),
    }
}

/// The picture that was wanted, the pictures before and after, and the difference that is left. All have one size.
pub fn of_pictures(target: &Frame, [before, after]: [&Frame; 2], described: &str) -> Chart {
    let size = [target.width, target.height];
    let panel = |name: &str, values: MapValues| MapPanel { name: name.to_owned(), size, values };
    let shown = |frame: &Frame| MapValues::Colours(frame.linear.clone());
    Chart::Map(MapChart {
        heading: ChartHeading { title: "Fit to a picture".to_owned(), subtitle: described.to_owned() },
        axes: None,
        bar: ChartAxis { title: "difference".to_owned(), ..ChartAxis::default() },
        panels: vec![
            panel("wanted", shown(target)),
            panel("before", shown(before)),
            panel("after", shown(after)),
            panel("difference", MapValues::Numbers(difference(after, target))),
        ],
    })
}
