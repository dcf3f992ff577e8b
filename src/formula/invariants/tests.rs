//! Invariant systems on the thesis's examples and on arbitrary ones.

use super::*;
use crate::lang::types::Type;
use proptest::prelude::*;

fn scalar(name: &str, default: f32) -> Parameter {
    Parameter {
        switch: false,
        image: None,
        choices: Vec::new(),
        name: name.to_owned(),
        owner: Owner::Body,
        ty: Type::Scalar,
        range: Some([0.0, 1.0]),
        default: [default, 0.0, 0.0],
        slider: true,
        colour: false,
        doc: None,
        predefined: None,
        slot: 0,
    }
}

/// Parameters from `names`, invariants from lines such as `a+b=1`.
fn build(names: &[(&str, f32)], lines: &[&str]) -> (Vec<Parameter>, Vec<Invariant>) {
    let parameters: Vec<Parameter> = names.iter().map(|(name, default)| scalar(name, *default)).collect();
    let id = |name: &str| ParameterId(names.iter().position(|(other, _)| *other == name).unwrap() as u32);
    let invariants = lines
        .iter()
        .map(|line| {
            let (sum, relation) = match line.strip_suffix("<=1") {
                Some(sum) => (sum, Relation::AtMost),
                None => (line.strip_suffix("=1").unwrap(), Relation::Equal),
            };
            Invariant { terms: sum.split('+').map(id).collect(), relation }
        })
        .collect();
    (parameters, invariants)
}

fn system(names: &[(&str, f32)], lines: &[&str]) -> InvariantSystem {
    let (parameters, invariants) = build(names, lines);
    InvariantSystem::new(&parameters, &invariants, Owner::Body).unwrap().0
}

fn explanations(names: &[&str], lines: &[&str]) -> Vec<String> {
    let pairs: Vec<(&str, f32)> = names.iter().map(|name| (*name, 0.0)).collect();
    let system = system(&pairs, lines);
    system.dependents().iter().map(|dependent| system.explanation(dependent.parameter).unwrap()).collect()
}

#[test]
fn the_last_named_follows() {
    assert_eq!(explanations(&["ks", "kd", "kr", "kt"], &["ks+kd=1", "kr+kt=1"]), ["kd = 1 - ks", "kt = 1 - kr"]);
    assert_eq!(explanations(&["ks", "kd", "kt"], &["ks+kd+kt=1"]), ["kt = 1 - ks - kd"]);
    assert_eq!(explanations(&["ks", "kd", "kt", "kr"], &["ks+kd+kt=1", "kr+kt=1"]), ["kt = 1 - ks - kd", "kr = ks + kd"]);
    assert_eq!(explanations(&["a", "b"], &["a+b+b=1"]), ["b = 0.5 - 0.5*a"]);
    assert_eq!(explanations(&["a"], &["a=1"]), ["a = 1"]);
}

#[test]
fn where_nothing_is_free_all_are_locked() {
    assert_eq!(explanations(&["a", "b", "c"], &["a+b=1", "b+c=1", "a+c=1"]), ["b = 0.5", "c = 0.5", "a = 0.5"]);
}

#[test]
fn a_cancelled_last_name_gives_way_to_the_last_of_what_remains() {
    // After a+b=1 the second line is 1 + c + d = 1 with its last name, b, cancelled against a.
    let names = ["a", "b", "c", "d"];
    assert_eq!(explanations(&names, &["a+b=1", "c+d+a+b=1"]), ["b = 1 - a", "d = -c"]);
    // x+y=1, then x+z=1 locks z; in y+w+z, y and z are 1-x each, w the last free one named.
    assert_eq!(explanations(&["x", "y", "z", "w"], &["x+y=1", "x+z=1", "y+w+z=1"]), ["y = 1 - x", "z = 1 - x", "w = -1 + 2*x"]);
    // In c+b+a, b = 1-a cancels a, the last free name: c, the last of what remains, is locked.
    assert_eq!(explanations(&["a", "b", "c"], &["a+b=1", "c+b+a=1"]), ["b = 1 - a", "c = 0"]);
}

#[test]
fn contradictions_name_an_irreducible_part() {
    let (parameters, invariants) = build(&[("a", 0.0), ("b", 0.0), ("c", 0.0)], &["c<=1", "a+b=1", "a+c+c=1", "a+a+b+b=1"]);
    let error = InvariantSystem::new(&parameters, &invariants, Owner::Body).unwrap_err();
    assert_eq!(error.invariants, [1, 3]);
    // Consistent as a linear system, but a would be 1 and b 1.
    let (parameters, invariants) = build(&[("a", 0.0), ("b", 0.0)], &["a=1", "b=1", "a+b<=1"]);
    let error = InvariantSystem::new(&parameters, &invariants, Owner::Body).unwrap_err();
    assert_eq!(error.invariants, [0, 1, 2]);
}

#[test]
fn redundant_lines_are_told() {
    let (parameters, invariants) = build(&[("a", 0.0), ("b", 0.0), ("c", 0.0)], &["a+b=1", "b+a=1", "a+c<=1"]);
    let (system, redundant) = InvariantSystem::new(&parameters, &invariants, Owner::Body).unwrap();
    assert_eq!(redundant, [1]);
    assert_eq!(system.free(), [ParameterId(0), ParameterId(2)]);
}

#[test]
fn a_moved_value_stays_where_everything_holds() {
    let system = system(&[("ks", 0.0), ("kd", 0.0), ("kt", 0.0)], &["ks+kd+kt=1"]);
    let values = |id: ParameterId| [0.3, 0.5, 0.2][id.0 as usize];
    assert_eq!(system.range_of(ParameterId(0), values), Some([0.0, 0.5]));
    assert_eq!(system.range_of(ParameterId(9), values), None);
    assert_eq!(system.move_one(ParameterId(0), 0.9, values), [(ParameterId(0), 0.5), (ParameterId(2), 0.0)]);
    assert_eq!(system.move_one(ParameterId(2), 0.9, values), []);
    assert_eq!(system.moved_with(ParameterId(1)), [(ParameterId(1), 1.0), (ParameterId(2), -1.0)]);
}

#[test]
fn later_names_give_way() {
    let system = system(&[("a", 0.0), ("b", 0.0), ("c", 0.0)], &["b+a+c<=1"]);
    let settled = |wanted: [f32; 3]| {
        let settled = system.settle(|id| wanted[id.0 as usize]);
        [0, 1, 2].map(|id| settled.iter().find(|(other, _)| other.0 == id).unwrap().1)
    };
    // Named first b, then a, then c.
    assert_eq!(settled([0.5, 0.8, 0.4]), [0.2, 0.8, 0.0]);
    assert_eq!(settled([0.6, 0.4, 0.0]), [0.6, 0.4, 0.0]);
    assert_eq!(settled([0.1, 0.2, 0.9]), [0.1, 0.2, 0.7]);
    assert_eq!(settled([f32::NAN, 2.0, -1.0]), [0.0, 1.0, 0.0]);
}

#[test]
fn an_earlier_name_gives_way_to_what_no_later_one_could_mend() {
    // kr = ks + kd must be at most 0.5 where kr + kr <= 1 would hold.
    let system = system(&[("ks", 0.0), ("kd", 0.0), ("kt", 0.0)], &["ks+kd=1", "kt+ks+ks<=1"]);
    let settled = system.settle(|id| [0.9, 0.3, 0.4][id.0 as usize]);
    assert_eq!(settled, [(ParameterId(0), 0.5), (ParameterId(2), 0.0), (ParameterId(1), 0.5)]);
}

#[test]
fn the_thesis_example_has_two_conflicts() {
    let (parameters, invariants) = build(&[("kd", 0.2), ("ks", 0.5), ("kr", 0.0), ("kt", 0.0)], &["ks+kd=1", "kr+kt=1"]);
    let conflicts: Vec<(u32, f32, f32)> =
        default_conflicts(&parameters, &invariants).iter().map(|c| (c.parameter.0, c.given, c.settled)).collect();
    assert_eq!(conflicts, [(0, 0.2, 0.5), (3, 0.0, 1.0)]);
}

#[test]
fn numbers_are_shown_short() {
    let shown: Vec<String> = [0.5, -0.0, 0.6 - 3e-8, 1.0 / 3.0, 150.0, 1e-9, 3e30].map(short).to_vec();
    assert_eq!(shown, ["0.5", "0", "0.6", "0.333333", "150", "1e-9", "3e30"]);
}

/// Lines over five parameters, as lists of terms with their relation.
fn lines() -> impl Strategy<Value = Vec<(Vec<u32>, bool)>> {
    prop::collection::vec((prop::collection::vec(0..5u32, 1..4), any::<bool>()), 1..5)
}

fn arbitrary(lines: &[(Vec<u32>, bool)]) -> Option<(InvariantSystem, Vec<Invariant>)> {
    let parameters: Vec<Parameter> = ["a", "b", "c", "d", "e"].iter().map(|name| scalar(name, 0.0)).collect();
    let invariants: Vec<Invariant> = lines
        .iter()
        .map(|(terms, equal)| Invariant {
            terms: terms.iter().copied().map(ParameterId).collect(),
            relation: if *equal { Relation::Equal } else { Relation::AtMost },
        })
        .collect();
    let (system, _) = InvariantSystem::new(&parameters, &invariants, Owner::Body).ok()?;
    Some((system, invariants))
}

/// By how much values miss the invariant that they miss most.
fn missed(invariants: &[Invariant], values: impl Fn(ParameterId) -> f32) -> f64 {
    let misses = invariants.iter().map(|line| {
        let sum: f64 = line.terms.iter().map(|term| f64::from(values(*term))).sum();
        match line.relation {
            Relation::Equal => (sum - 1.0).abs(),
            Relation::AtMost => sum - 1.0,
        }
    });
    misses.fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn settled_values_satisfy_everything_and_stay(lines in lines(), wanted in prop::array::uniform5(-0.2f32..1.2)) {
        let Some((system, invariants)) = arbitrary(&lines) else { return Ok(()) };
        let settle = |wanted: [f32; 5]| {
            let mut values = wanted;
            for (id, value) in system.settle(|id| wanted[id.0 as usize]) {
                values[id.0 as usize] = value;
            }
            values
        };
        let settled = settle(wanted);
        let named: Vec<ParameterId> = invariants.iter().flat_map(|line| line.terms.clone()).collect();
        prop_assert!(named.iter().all(|id| (0.0..=1.0).contains(&settled[id.0 as usize])));
        prop_assert!(missed(&invariants, |id| settled[id.0 as usize]) <= 1e-6, "{settled:?}");
        let again = settle(settled);
        let locked = |index: &usize| system.is_locked(ParameterId(*index as u32));
        for index in (0..5).filter(|index| !locked(index)) {
            prop_assert_eq!(again[index], settled[index]);
        }
    }

    #[test]
    fn the_first_name_gives_way_only_where_it_must(lines in lines(), wanted in prop::array::uniform5(0.0f32..1.0)) {
        let Some((system, _)) = arbitrary(&lines) else { return Ok(()) };
        let Some(first) = system.free().first() else { return Ok(()) };
        let [low, high] = system.polytope.interval(&[], 1e-9).unwrap();
        let settled = system.settle(|id| wanted[id.0 as usize])[0].1;
        let nearest = f64::from(wanted[first.0 as usize]).clamp(low, high);
        prop_assert!((f64::from(settled) - nearest).abs() <= 1e-6, "{settled} {nearest}");
    }

    #[test]
    fn moves_keep_everything(lines in lines(), wanted in prop::array::uniform5(0.0f32..1.0),
                             moves in prop::collection::vec((0..5u32, -0.5f32..1.5), 1..8)) {
        let Some((system, invariants)) = arbitrary(&lines) else { return Ok(()) };
        let mut values = wanted;
        for (id, value) in system.settle(|id| wanted[id.0 as usize]) {
            values[id.0 as usize] = value;
        }
        for (id, value) in moves {
            let before = values;
            for (id, value) in system.move_one(ParameterId(id), value, |id| before[id.0 as usize]) {
                values[id.0 as usize] = value;
            }
        }
        prop_assert!(missed(&invariants, |id| values[id.0 as usize]) <= 1.5e-6, "{values:?}");
    }
}
