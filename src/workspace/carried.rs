//! Which values another formula or scene takes over by name, in words.

use crate::formula::ParameterId;
use crate::lang::variables::Predefined;
use crate::workspace::ParameterTable;
use crate::workspace::Values;
use crate::workspace::session::{MissingTarget, OwnerName, Session};

/// The most names in a sentence. A longer one is not read.
const FEW: usize = 12;

/// The values that another formula or scene takes over, and those that it does not.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CarriedValues {
    /// The parameters that have a value from before.
    pub kept: Vec<String>,
    /// The parameters that the formula does not have.
    pub without_parameter: Vec<String>,
    /// The bodies and lights that the scene does not have.
    pub without_owner: Vec<String>,
    /// The predefined parameters whose new default, of the section `predefined` of the formula, is not used, because a
    /// value from before is kept.
    pub unused_defaults: Vec<String>,
}

impl CarriedValues {
    /// The values of a session, for a formula on a scene of which one, or both, are `replaced`. What is missing in the
    /// other one is left out.
    pub fn of_session(session: &Session, table: &ParameterTable, replaced: [bool; 2]) -> Self {
        let mut carried = Self::default();
        let add = |names: &mut Vec<String>, name: &str| {
            if !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        };
        for value in &session.values {
            match value.assignment(table) {
                Ok(assignment) => {
                    add(&mut carried.kept, &value.parameter);
                    if replaced[0] && has_other_default(table, assignment.parameter, &assignment.value) {
                        add(&mut carried.unused_defaults, &value.parameter);
                    }
                }
                Err(leftover) if leftover.missing == MissingTarget::Parameter => {
                    add(&mut carried.without_parameter, &value.parameter);
                }
                Err(_) => match &value.owner {
                    OwnerName::Body(name) | OwnerName::Light(name) => add(&mut carried.without_owner, name),
                    OwnerName::Global => {}
                },
            }
        }
        let [formula_is_other, scene_is_other] = replaced;
        carried.without_parameter.retain(|name| formula_is_other && !carried.kept.contains(name));
        carried.without_owner.retain(|_| scene_is_other);
        carried
    }

    /// The values of one formula on a scene, for another formula, which has them now.
    pub fn between(old: &ParameterTable, values: &Values) -> Self {
        let new = values.table();
        let mut carried = Self::default();
        let kinds = crate::lang::variables::Owner::ALL.into_iter();
        for id in kinds.flat_map(|kind| old.parameters_of(kind)) {
            let parameter = old.parameter(id);
            let same = new.parameter_named(&parameter.name).map(|id| new.parameter(id));
            let is_kept = same.is_some_and(|same| (same.owner, same.ty) == (parameter.owner, parameter.ty));
            let names = if is_kept { &mut carried.kept } else { &mut carried.without_parameter };
            names.push(parameter.name.clone());
        }
        for (_, id, value) in values.iter() {
            let (name, default) = (&new.parameter(id).name, new.parameter(id).default);
            let had_it = old.parameter_named(name).is_some_and(|id| old.parameter(id).default == default);
            if !had_it && has_other_default(new, id, value) && !carried.unused_defaults.contains(name) {
                carried.unused_defaults.push(name.clone());
            }
        }
        carried
    }

    /// Which values are kept and which are not; `None` if there are none at all.
    pub fn sentence(&self) -> Option<String> {
        let gone = [("the formula", &self.without_parameter), ("the scene", &self.without_owner)];
        let gone: Vec<String> = gone
            .into_iter()
            .filter(|(_, names)| !names.is_empty())
            .map(|(what, names)| format!("{what} has no {}", listed(names)))
            .collect();
        let kept = match self.kept.as_slice() {
            [] if gone.is_empty() => return None,
            [] => "no values are kept by name".to_owned(),
            names => format!("values kept by name: {}", listed(names)),
        };
        let unused = match self.unused_defaults.as_slice() {
            [] => None,
            names => Some(format!("the formula's own defaults are not used for {}", listed(names))),
        };
        Some(std::iter::once(kept).chain(gone).chain(unused).collect::<Vec<_>>().join("; "))
    }
}

/// Whether the formula gives a predefined parameter a default of its own, and the value is another.
fn has_other_default(table: &ParameterTable, id: ParameterId, value: &[f32]) -> bool {
    let parameter = table.parameter(id);
    let is_own = |predefined: Predefined| !parameter.default.starts_with(predefined.default());
    let default = &parameter.default[..parameter.ty.slots()];
    parameter.predefined.is_some_and(is_own) && !value.starts_with(default)
}

fn listed(names: &[String]) -> String {
    match names.len() {
        0..=FEW => names.join(", "),
        all => format!("{} and {} others", names[..FEW].join(", "), all - FEW),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::scene::Scene;

    fn texts(formula: &str) -> (Formula, Scene) {
        let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <9,9,9>;
            camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
        let formula = Formula::parse(&Source::new("f", formula)).expect("a formula").0;
        (formula, Scene::parse(&Source::new("s", scene)).expect("a scene").0)
    }

    fn table(formula: &str) -> ParameterTable {
        let (formula, scene) = texts(formula);
        ParameterTable::new(&formula, &scene)
    }

    fn values(formula: &str) -> Values {
        let (formula, scene) = texts(formula);
        Values::defaults(&formula, &scene)
    }

    fn sentence(values: &str, replaced: [bool; 2]) -> Option<String> {
        let text = format!("version = 1\nformula = \"a\"\nscene = \"b\"\n{values}");
        let session = Session::parse(&Source::new("s.toml", text)).expect("a session").0;
        let table = table("body_specific; kd: scalar; ks: vector; formula; = kd*ks;");
        CarriedValues::of_session(&session, &table, replaced).sentence()
    }

    #[test]
    fn every_name_is_in_one_place() {
        let all = "[global]\nka = 0.2\n[bodies.ball]\nkd = 0.5\nh = 2\nks = 1\n[bodies.cone]\nkd = 1\n[lights.sun]\nki = 1\n";
        let said = sentence(all, [true; 2]);
        assert_eq!(said.as_deref(), Some("values kept by name: ka, kd; the formula has no h, ks; the scene has no cone, sun"));
        assert_eq!(sentence(all, [true, false]).as_deref(), Some("values kept by name: ka, kd; the formula has no h, ks"));
        assert_eq!(sentence(all, [false, true]).as_deref(), Some("values kept by name: ka, kd; the scene has no cone, sun"));
        let said = sentence("[bodies.cone]\nkd = 1\n", [true; 2]);
        assert_eq!(said.as_deref(), Some("no values are kept by name; the scene has no cone"));
        assert_eq!(sentence("", [true; 2]), None);
    }

    #[test]
    fn formulas_are_compared_by_name_owner_and_type() {
        let old = table("body_specific; kd: scalar; ks: scalar; h: scalar; g: scalar; formula; = kd*ks*h*g*Cd;");
        let new = values("body_specific; kd: scalar; ks: vector; n: scalar; light_specific; g: scalar; formula; = kd*n*ks*g;");
        let carried = CarriedValues::between(&old, &new);
        assert_eq!(carried.without_parameter, ["ks", "h", "g"]);
        assert!(carried.kept.contains(&"kd".to_owned()) && carried.kept.contains(&"Cd".to_owned()));
    }

    #[test]
    fn defaults_of_the_formula_that_are_not_used_are_named() {
        let predefined = "predefined; ki: constraint 0..50, default 5; ka: default 0.2; kr: default 0; formula; = Cd;";
        let said = |replaced: [bool; 2]| {
            let text = "version = 1\nformula = \"a\"\nscene = \"b\"\n[global]\nka = 0.2\n[bodies.ball]\nkr = 0.1\n[lights.key]\nki = 1\n";
            let session = Session::parse(&Source::new("s.toml", text)).expect("a session").0;
            CarriedValues::of_session(&session, &table(predefined), replaced).sentence()
        };
        let kept = "values kept by name: ka, kr, ki";
        assert_eq!(said([true, false]), Some(format!("{kept}; the formula's own defaults are not used for ki")));
        assert_eq!(said([false, true]).as_deref(), Some(kept));
        // Applied in place of another formula, it has that one's values.
        let old = values("formula; = Cd;");
        let (formula, scene) = texts(predefined);
        let kept = old.carry_over(&formula, &scene).0;
        assert_eq!(CarriedValues::between(old.table(), &kept).unused_defaults, ["ka", "ki"]);
        assert_eq!(CarriedValues::between(kept.table(), &kept).unused_defaults, [""; 0]);
    }

    #[test]
    fn long_lists_are_cut() {
        let names: Vec<String> = (0..14).map(|index| format!("p{index}")).collect();
        assert!(listed(&names).ends_with("p11 and 2 others"));
    }
}
