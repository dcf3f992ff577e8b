//! What is measured of formulas.

use crate::{folder, run, told, write};
use serde_json::Value;
use std::path::Path;

fn measured(folder: &Path, arguments: &str) -> Value {
    let output = run(folder, &format!("measure --json {arguments}"));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments}");
    assert_eq!(output.status.code(), Some(0), "{arguments}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn near(found: &Value, wanted: f64, tolerance: f64) {
    let number = found.as_f64().expect("a number");
    assert!((number - wanted).abs() <= tolerance, "{number}, not {wanted}");
}

#[test]
fn a_matte_surface_has_nothing_odd() {
    let folder = folder();
    write(&folder, "matte.formula", "formula; = IL*Cd*max(0, N.L);");
    let found = measured(folder.path(), "--formula matte.formula --set Cd=<0.9,0.6,0.3>");
    assert_eq!((&found["conserves_energy"], &found["is_reciprocal"]), (&Value::Bool(true), &Value::Bool(true)));
    assert_eq!((&found["depends_on_azimuth"], &found["not_finite"]), (&Value::Bool(false), &Value::Null));
    near(&found["greatest_albedo"]["share"], 0.9, 2e-4);
    assert_eq!(found["greatest_albedo"]["component"], "red");
    let rows = found["albedo"].as_array().expect("rows");
    let angles: Vec<f64> = rows.iter().filter_map(|row| row["theta"].as_f64()).collect();
    assert_eq!(angles, [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0, 89.0]);
    for row in rows {
        for (component, wanted) in [0.9, 0.6, 0.3].into_iter().enumerate() {
            near(&row["beam"][component], wanted, 2e-4);
            near(&row["furnace"][component], wanted, 2e-4);
        }
    }
}

#[test]
fn light_that_is_made_is_found_with_its_angle() {
    let folder = folder();
    write(&folder, "gain.formula", "formula; = IL*max(0, N.L)*(1.5 - N.L);");
    let found = measured(folder.path(), "gain.formula");
    assert_eq!(found["conserves_energy"], false);
    near(&found["greatest_albedo"]["share"], 1.5, 1e-3);
    near(&found["greatest_albedo"]["above_one_from"], 60.0, 0.3);
    // The mean over the light: ∫ (1.5 − c) 2c dc.
    near(&found["greatest_in_furnace"]["share"], 1.5 - 2.0 / 3.0, 2e-4);
    near(&found["albedo"][6]["beam"][0], 1.0, 2e-4);
    assert_eq!(found["is_reciprocal"], false);
    let said = told(folder.path(), "measure gain.formula");
    let verdict = said.lines().find(|line| line.starts_with("energy")).expect("a verdict");
    assert!(verdict.contains("NOT conserved: 1.5") && verdict.contains("above 1 from 60."), "{said}");
    assert!(said.contains("furnace       at most 0.833") && said.ends_with("exit status 0\n"), "{said}");
}

#[test]
fn odd_values_are_told_with_their_places() {
    let folder = folder();
    let text = "formula; LOW = N.L - 0.5; ROOT = sqrt(LOW); BELOW = N.V - 2; WIDE = <0, 1, alpha>; = IL*ROOT*BELOW + 0*WIDE;";
    write(&folder, "odd.formula", text);
    let found = measured(folder.path(), "odd.formula");
    let expressions = found["expressions"].as_array().expect("a list");
    let named = |name: &str| expressions.iter().find(|found| found["name"] == name).expect("an expression");
    near(&named("LOW")["least"], -0.5, 0.01);
    near(&named("LOW")["greatest"], 0.5, 1e-6);
    assert!(named("ROOT")["not_numbers"].as_u64() > Some(100) && named("LOW")["not_numbers"] == 0);
    near(&named("ROOT")["greatest"], 0.5_f64.sqrt(), 1e-6);
    near(&named("BELOW")["least"], -2.0, 0.01);
    near(&named("BELOW")["greatest"], -1.0, 1e-6);
    near(&named("WIDE")["greatest"], std::f64::consts::FRAC_PI_2, 0.01);
    // A light that is lower than 60° has no root.
    let light = found["not_finite"]["light"][0].as_f64().expect("an angle");
    assert!(light > 60.0, "{light}");
    near(&found["smallest"]["value"], -2.0 * 0.5_f64.sqrt(), 0.01);
    let said = told(folder.path(), "measure odd.formula");
    assert!(said.contains("NOT FINITE") && said.contains("NEGATIVE") && said.contains("NaN for"), "{said}");
}

#[test]
fn a_session_has_the_values_of_its_bodies() {
    let folder = folder();
    // kd = 0.5 and ks = 0.2 at h = 20 reflect kd Cd + 2 ks/(h + 2) of light from the normal.
    let shine = 0.4 / 22.0;
    let found = measured(folder.path(), "session.toml");
    near(&found["albedo"][0]["beam"][0], 0.5 + shine, 2e-4);
    near(&found["albedo"][0]["beam"][1], shine, 2e-4);
    let found = measured(folder.path(), "session.toml --body floor");
    near(&found["albedo"][0]["beam"][0], 0.4 + shine, 2e-4);
    assert!(found["model"].as_str().is_some_and(|model| model.contains("floor under key of session.toml")), "{}", found["model"]);
    assert!(told(folder.path(), "measure session.toml --body ball2").contains("did you mean `ball`?"));
}

#[test]
fn the_ranges_of_parameters_are_looked_at() {
    let folder = folder();
    let text = "body_specific; kd: scalar, constraint 0..2, default 0.5; shift: scalar, constraint 0..0.25;
        formula; = IL*<kd>*max(0, N.L) - <shift>*max(0, N.L);";
    write(&folder, "wide.formula", text);
    let found = measured(folder.path(), "wide.formula --all");
    assert_eq!((&found["conserves_energy"], &found["ranges"]["parameters"]), (&true.into(), &serde_json::json!(["kd", "shift"])));
    near(&found["ranges"]["greatest_albedo"]["share"], 2.0, 1e-3);
    assert_eq!(found["ranges"]["greatest_with"], "kd=2 shift=0");
    near(&found["ranges"]["smallest"], -0.25, 1e-3);
    assert_eq!(found["ranges"]["smallest_with"], "kd=0 shift=0.25");
    // Four corners, and settings inside: where kd − shift is above 1.
    let [settings, above] = ["settings", "above_one"].map(|name| found["ranges"][name].as_u64().expect("a number"));
    assert!(settings == 36 && (12..=20).contains(&above), "{settings} {above}");
    let said = told(folder.path(), "measure wide.formula --all");
    assert!(said.contains("  energy        NOT conserved by ") && said.contains("with kd=2 shift=0"), "{said}");
    let without = measured(folder.path(), "wide.formula");
    assert!(without.get("ranges").is_none());
}

#[test]
fn the_worst_setting_of_an_anisotropic_model_is_found_at_any_azimuth() {
    let folder = folder();
    // Across the tangent, light along the surface is reflected by up to 1.8 s; along the tangent by 1.2 (1 − s).
    let text = "body_specific; s: scalar, constraint 0..1, default 0.5;
        formula; = IL*<1.2*(1 - s)*(T.L)^2 + 1.8*s*(B.L)^2>*max(0, N.L);";
    write(&folder, "across.formula", text);
    let found = measured(folder.path(), "across.formula --all");
    assert_eq!(found["ranges"]["greatest_with"], "s=1");
    near(&found["ranges"]["greatest_albedo"]["share"], 1.8, 2e-3);
}

#[test]
fn what_cannot_be_told_is_not_told() {
    let folder = folder();
    write(&folder, "none.formula", "formula; = IL*sqrt(-1 - N.L);");
    let found = measured(folder.path(), "none.formula");
    assert_eq!((&found["conserves_energy"], &found["smallest"]), (&Value::Null, &Value::Null));
    assert_eq!(found["not_finite"]["light"].as_array().map(Vec::len), Some(2));
    let said = told(folder.path(), "plot none.formula --view furnace -o none.svg");
    assert_eq!(said, "Warning: some values are not numbers; they are magenta in pictures\nexit status 0\n");
    let chart = std::fs::read_to_string(folder.path().join("none.svg")).expect("a chart");
    assert!(chart.contains("the ball has no finite value"));
    let said = told(folder.path(), "measure none.formula");
    assert!(said.contains("energy        unknown: there is no finite value"), "{said}");
    // Half of the directions reflect everything, in stripes that are too narrow to be integrated.
    write(&folder, "stripes.formula", "formula; = IL*if(fract(999*getx(V)) < 0.5, 1, 0)*max(0, N.L);");
    let said = told(folder.path(), "measure stripes.formula");
    assert!(said.contains("ACCURACY      low: shares may be wrong by "), "{said}");
    assert!(said.contains("conserved: about 0.5") && said.contains(" ± 0.") && said.contains("in a furnace       ±"), "{said}");
    write(&folder, "huge.formula", "formula; = IL*1e38*max(0, N.L);");
    let said = told(folder.path(), "measure huge.formula");
    assert!(said.contains("NOT conserved: 1.000e38 of the light"), "{said}");
}

/// The axis of lobes in the following formulas, and the cosine of its angle from the normal.
const AXIS: &str = "A = normalize(0.3*T + 0.8*B + N);";
const AXIS_COSINE: f64 = 0.760_286;
/// Its polar angle and azimuth in degrees.
const AXIS_ANGLES: [f64; 2] = [40.511, 69.444];

#[test]
fn lobes_at_any_azimuth_are_found() {
    let folder = folder();
    for exponent in [50.0, 400.0] {
        let text =
            format!("formula; {AXIS} = IL*<0.9*({exponent}+1)*max(0, A.V)^{exponent}*max(0, A.L)^{exponent}>*max(0, N.L);");
        write(&folder, "lobe.formula", &text);
        let found = measured(folder.path(), "lobe.formula");
        // At the axis: c/π ∫ (A.V)ⁿ N.V dω = 2 c (A.N)/(n + 2), with c = 0.9 (n + 1).
        let wanted = 1.8 * (exponent + 1.0) * AXIS_COSINE / (exponent + 2.0);
        near(&found["greatest_albedo"]["share"], wanted, 2e-3);
        near(&found["greatest_albedo"]["theta"], AXIS_ANGLES[0], 0.3);
        near(&found["greatest_albedo"]["phi"], AXIS_ANGLES[1], 0.5);
        assert_eq!((&found["conserves_energy"], &found["is_reciprocal"]), (&false.into(), &true.into()));
        // Above 1 where (A.L)ⁿ is above 1/wanted; along this azimuth, that is as far on both sides.
        let away = wanted.powf(-1.0 / exponent).acos().to_degrees();
        near(&found["greatest_albedo"]["above_one_from"], AXIS_ANGLES[0] - away, 0.4);
        near(&found["greatest_albedo"]["above_one_to"], AXIS_ANGLES[0] + away, 0.4);
    }
    // A lobe around the axis for the viewer alone: in a furnace, 1.3 (A.V)ⁿ.
    write(&folder, "fixed.formula", &format!("formula; {AXIS} = IL*<1.3*max(0, A.V)^200>*max(0, N.L);"));
    let found = measured(folder.path(), "fixed.formula");
    near(&found["greatest_in_furnace"]["share"], 1.3, 2e-3);
    near(&found["greatest_albedo"]["share"], 2.6 * AXIS_COSINE / 202.0, 5e-4);
    let said = told(folder.path(), "measure fixed.formula");
    assert!(said.contains("at azimuth 0°") && said.contains("the same at azimuth "), "{said}");
}

#[test]
fn patterns_over_the_azimuth_are_found() {
    let folder = folder();
    for waves in [4.0, 12.0] {
        write(&folder, "waves.formula", &format!("formula; = IL*<0.7 + 0.35*sin({waves}*atan2(L.B, L.T))>*max(0, N.L);"));
        let found = measured(folder.path(), "waves.formula");
        near(&found["greatest_albedo"]["share"], 1.05, 1e-3);
        near(&found["greatest_in_furnace"]["share"], 0.7, 1e-3);
        assert_eq!((&found["conserves_energy"], &found["depends_on_azimuth"]), (&false.into(), &true.into()));
        let rows = found["albedo"].as_array().expect("rows");
        assert_eq!(rows.len(), 22);
        // sin is 1 at a quarter of each wave.
        let phi = rows[15]["phi"].as_f64().expect("an angle");
        assert!((phi * waves / 360.0 - 0.25).rem_euclid(1.0).min((0.25 - phi * waves / 360.0).rem_euclid(1.0)) < 0.03, "{phi}");
        near(&rows[15]["beam"][0], 1.05, 3e-3);
        near(&rows[4]["beam"][0], 0.7, 1e-3);
    }
    // A woven surface, reciprocal: the share is 1.4 w(L) times the mean of w, which is 0.7.
    let text = "formula; w(d) = 0.7 + 0.35*sin(4*atan2(d.B, d.T)); = IL*<1.4*w(L)*w(V)>*max(0, N.L);";
    write(&folder, "woven.formula", text);
    let found = measured(folder.path(), "woven.formula");
    near(&found["greatest_albedo"]["share"], 1.4 * 1.05 * 0.7, 2e-3);
    assert_eq!((&found["conserves_energy"], &found["is_reciprocal"]), (&false.into(), &true.into()));
}

#[test]
fn narrow_features_are_found() {
    let folder = folder();
    write(&folder, "band.formula", "formula; = IL*<if(N.L > 0.78 && N.L < 0.8, 1.2, 0.2)>*max(0, N.L);");
    let found = measured(folder.path(), "band.formula");
    near(&found["greatest_albedo"]["share"], 1.2, 1e-3);
    near(&found["greatest_albedo"]["above_one_from"], 0.8_f64.acos().to_degrees(), 0.2);
    near(&found["greatest_albedo"]["above_one_to"], 0.78_f64.acos().to_degrees(), 0.2);
    // In a furnace: 0.2, and 1 more on the ring: 0.8² − 0.78².
    near(&found["greatest_in_furnace"]["share"], 0.2 + 0.64 - 0.6084, 2e-3);
    assert_eq!((&found["conserves_energy"], &found["is_reciprocal"]), (&false.into(), &false.into()));
    let said = told(folder.path(), "measure band.formula");
    assert!(said.contains("above 1 from 36.") && said.contains("° to 38."), "{said}");
    // ∫ exp(−k (1 − A.V)) N.V dω = 2π (A.N)/k, as k is large.
    write(&folder, "needle.formula", &format!("formula; {AXIS} = IL*<1.05*5e4*exp(-1e5*(1 - A.V))/(A.N)>*max(0, N.L);"));
    let found = measured(folder.path(), "needle.formula");
    // Single precision has seven digits of 1 − A.V.
    near(&found["greatest_albedo"]["share"], 1.05, 5e-3);
    assert_eq!((&found["conserves_energy"], &found["depends_on_azimuth"]), (&false.into(), &true.into()));
    write(&folder, "gap.formula", "formula; = IL*<if(N.V > 0.601 && N.V < 0.602, sqrt(-1 - N.V), 0.5)>*max(0, N.L);");
    let found = measured(folder.path(), "gap.formula");
    near(&found["not_finite"]["view"][0], 0.6015_f64.acos().to_degrees(), 0.04);
}

/// The greatest share of a beam, and its error.
fn greatest(found: &Value) -> [f64; 2] {
    ["share", "error"].map(|name| found["greatest_albedo"][name].as_f64().expect("a number"))
}

#[test]
fn the_verdict_is_never_below_a_row_of_the_table() {
    let folder = folder();
    for (exponent, allowed) in [(1e5, 0.02), (2e6, 0.3)] {
        let text = format!("formula; c = max(R.V, 0); = IL*<0.3 + {exponent}*c^{exponent}>*max(0, N.L);");
        write(&folder, "needle.formula", &text);
        let found = measured(folder.path(), "needle.formula");
        assert_eq!((&found["conserves_energy"], &found["energy"]), (&false.into(), &"not conserved".into()));
        let [share, error] = greatest(&found);
        let rows = found["albedo"].as_array().expect("rows");
        let of_rows = rows.iter().filter_map(|row| row["beam"][0].as_f64()).fold(0.0, f64::max);
        assert!(share >= of_rows, "{share} {of_rows}");
        // 0.3, and n/π ∫ cosⁿ N.V dω = 2 cos θ n/(n + 2), which is greatest at the normal.
        assert!((share - 2.3).abs() <= error + 2e-4 && error < allowed, "{exponent}: {share} ± {error}");
        let to = found["greatest_albedo"]["above_one_to"].as_f64().expect("an angle");
        // 0.35 = cos θ, less if the error is large.
        assert!(to < 0.35_f64.acos().to_degrees() + 0.5 && to > 60.0, "{to}");
    }
}

#[test]
fn streaks_are_found_at_their_azimuth() {
    let folder = folder();
    // Ashikhmin and Shirley (2000), with exponents of 10 and 10,000 and both colours 0.5.
    let ashikhmin = |factor: f64| {
        format!(
            "formula; nl = max(N.L, 0); nv = max(N.V, 0); nh = max(N.H, 1e-6); hk = max(L.H, 1e-6);
            e = (10*(H.T)^2 + 10000*(H.B)^2)/max(1 - nh*nh, 1e-12);
            s = sqrt(11*10001)/(8*pi)*nh^e/(hk*max(nl, nv))*(0.5 + 0.5*(1 - hk)^5);
            d = 7/(23*pi)*(1 - (1 - nl/2)^5)*(1 - (1 - nv/2)^5);
            = if(nl > 0 && nv > 0, <{factor}*pi*(s + d)*nl>, <0>)*IL;"
        )
    };
    // By Gauss rules graded towards the lobe, in NumPy: 0.69849 at 85°, 0.69944 at 85.5°, 0.69876 at 86°, azimuth 90°.
    for (factor, conserves) in [(1.0, true), (1.47, false)] {
        write(&folder, "streak.formula", &ashikhmin(factor));
        let found = measured(folder.path(), "streak.formula");
        near(&found["greatest_albedo"]["share"], factor * 0.69944, 1e-3);
        near(&found["greatest_albedo"]["theta"], 85.5, 0.5);
        near(&found["greatest_albedo"]["phi"], 90.0, 3.0);
        assert_eq!(found["conserves_energy"], conserves);
    }
    // Ward (1992) with roughnesses of 0.01 and 1. By integration over slopes, in NumPy: 7.4113 at 89.99° and azimuth
    // 90°, 7.369 at azimuth 85°.
    let ward = "formula; nl = max(N.L, 0); nv = max(N.V, 0); nh = max(N.H, 1e-6); t = H.T/0.01; b = H.B;
        = if(nl > 0 && nv > 0, <exp(-(t*t + b*b)/(nh*nh))/(4*0.01*sqrt(nl*nv))*nl>, <0>)*IL;";
    write(&folder, "ward.formula", ward);
    let found = measured(folder.path(), "ward.formula");
    near(&found["greatest_albedo"]["share"], 7.4113, 3e-3);
    near(&found["greatest_albedo"]["phi"].as_f64().map(|phi| phi % 180.0).into(), 90.0, 2.0);
    assert_eq!(found["greatest_albedo"]["at_last_angle"], true);
}

#[test]
fn rounding_is_part_of_the_error() {
    let folder = folder();
    // GGX that reflects everything. By integration over slopes in double precision: 1.0000 at the normal, where no
    // share is greater; 0.99957 at 89° with a roughness of 0.0005. In single precision, d has few digits.
    let ggx = |roughness: f64| {
        format!(
            "body_specific; al: scalar, default {roughness}; formula; nl = max(N.L, 0); nv = max(N.V, 0); nh = max(N.H, 0);
            a2 = al*al; d = nh*nh*(a2 - 1) + 1; lam(x) = (sqrt(1 + a2*(1 - x*x)/(x*x)) - 1)/2;
            = if(nl > 0 && nv > 0, <a2/(d*d)/(1 + lam(nl) + lam(nv))/(4*nv)>, <0>)*IL;"
        )
    };
    for roughness in [0.005, 0.0005] {
        write(&folder, "ggx.formula", &ggx(roughness));
        let found = measured(folder.path(), "ggx.formula");
        assert_ne!(found["conserves_energy"], false);
        let [share, error] = greatest(&found);
        assert!(share - error <= 1.0005, "{roughness}: {share} ± {error}");
        for row in found["albedo"].as_array().expect("rows").iter().take(7) {
            let [share, error] = [&row["beam"][0], &row["error"]].map(|number| number.as_f64().expect("a number"));
            assert!((share - 1.0).abs() <= error + 2e-4, "{roughness}: {row}");
        }
    }
    let found = measured(folder.path(), "ggx.formula");
    assert_eq!((&found["conserves_energy"], &found["energy"]), (&Value::Null, &"cannot be told".into()));
    let said = told(folder.path(), "measure ggx.formula");
    assert!(said.contains("energy        CANNOT BE TOLD: about 1.") && said.contains(" ± 0."), "{said}");
    // Disney's highlight at its narrowest, along the surface. By integration over slopes in double precision.
    let found = measured(folder.path(), "--formula preset:disney --set roughness=0 --set metallic=1 --set Cd=<1,1,1>");
    for (row, wanted) in [(0, 1.0), (3, 0.98971), (6, 0.91596), (8, 0.53472), (9, 0.24668), (10, 0.01733)] {
        near(&found["albedo"][row]["beam"][0], wanted, 5e-4);
    }
}

/// A lobe around the mirror direction, that reflects 0.98 of the light far above the horizon. The value has no factor
/// N.L, so the BRDF is not reciprocal: values are the same, and cosines of the light are not.
fn mirror(width: f64, factor: &str) -> String {
    let square = 0.98 / (width * width);
    format!("formula; d = length(R - V)/{width}; = if(N.L > 0, <{square}>*exp(-(d*d)){factor}, <0>);")
}

#[test]
fn narrow_lobes_that_are_not_reciprocal_are_found() {
    let folder = folder();
    // The share of a beam at 89.99°, by Gauss rules around the mirror direction, in NumPy.
    for (width, wanted) in [(0.002, None), (0.001, Some(2.12196)), (0.0005, Some(1.37658)), (0.0001, Some(0.98088))] {
        write(&folder, "mirror.formula", &mirror(width, ""));
        let found = measured(folder.path(), "mirror.formula");
        assert_eq!(found["is_reciprocal"], false, "{width}");
        let [light, view] = ["light", "view"].map(|end| found["reciprocity"][end][0].as_f64().expect("an angle"));
        let [light, view] = [light, view].map(|angle| angle.to_radians().cos());
        // Cosines of angles that are told to thousandths of a degree.
        near(&found["reciprocity"]["error"], 1.0 - light.min(view) / light.max(view), 0.03);
        assert!(found["reciprocity"]["error"].as_f64() > Some(0.5), "{width}: {}", found["reciprocity"]);
        near(&found["greatest_in_furnace"]["share"], 0.98, 2e-3);
        if let Some(wanted) = wanted {
            near(&found["greatest_albedo"]["share"], wanted, 2e-3);
        }
        assert!(told(folder.path(), "measure mirror.formula").contains("\nfurnace       at most 0.98"));
        // Divided by the greater cosine, and times that of the light, it is reciprocal.
        write(&folder, "both.formula", &mirror(width, "*(N.L)/max(N.L, N.V)"));
        let found = measured(folder.path(), "both.formula");
        assert_eq!(found["is_reciprocal"], true, "{width}: {}", found["reciprocity"]);
    }
}

/// A narrow lobe around a viewer at 42.1°, for light near 60°. At its top, both factors are 1.
const SPIKE: &str = "D = length(V - normalize(0.6*T + 0.3*B + 0.742*N))/0.004; E = (N.L - 0.5)/0.02; s = exp(-(D*D) - E*E);";

#[test]
fn the_largest_difference_is_inside_of_a_spike() {
    let folder = folder();
    write(&folder, "spike.formula", &format!("formula; {SPIKE} = if(N.L > 0, (N.L)*(<0.3> + <40000*s>), <0>);"));
    let found = measured(folder.path(), "spike.formula");
    // 40000.3 one way, 0.3 the other way.
    near(&found["reciprocity"]["error"], 1.0, 1e-3);
    near(&found["reciprocity"]["view"][0], 42.114, 1.0);
}

#[test]
fn thin_negative_spikes_are_found() {
    let folder = folder();
    write(&folder, "gap.formula", &format!("formula; {SPIKE} = max(N.L, 0)*<0.9 - 50*s>;"));
    let found = measured(folder.path(), "gap.formula");
    // The least of c (0.9 − 50 exp(−((c − 0.5)/0.02)²)), in NumPy: −24.5596 at c = 0.50039.
    near(&found["smallest"]["value"], -24.5596, 0.05);
    near(&found["smallest"]["light"][0], 59.974, 0.1);
    near(&found["smallest"]["view"][0], 42.114, 0.05);
    let said = told(folder.path(), "measure gap.formula");
    assert!(said.contains("smallest      NEGATIVE: -24.5"), "{said}");
    write(&folder, "matte.formula", "formula; = IL*<0.5>*max(0, N.L);");
    let said = told(folder.path(), "measure matte.formula");
    assert!(said.contains("no negative value found") && !said.contains("never"), "{said}");
}

#[test]
fn models_without_finite_values_in_most_directions_are_not_judged() {
    let folder = folder();
    // A finite value, 0, for one pair of directions in 400.
    write(&folder, "most.formula", "formula; = IL*if(N.V > 0.95 && N.L > 0.95, <0>, <1>/(0*(N.V)));");
    let found = measured(folder.path(), "most.formula");
    assert_eq!((&found["conserves_energy"], &found["energy"]), (&Value::Null, &"cannot be told".into()));
    assert_eq!((&found["is_reciprocal"], &found["depends_on_azimuth"]), (&Value::Null, &Value::Null));
    near(&found["part_not_finite"], 1.0 - 0.05 * 0.05, 2e-4);
    let said = told(folder.path(), "measure most.formula");
    assert!(said.contains("energy        CANNOT BE TOLD: 99.8 % of all pairs"), "{said}");
    for claim in ["conserved:", "reciprocal, to", "does not matter"] {
        assert!(!said.contains(claim), "{claim}: {said}");
    }
    // Shares far below 0 say nothing.
    write(&folder, "below.formula", "formula; = -IL*<exp(80*(1 - N.V))>;");
    assert_eq!(measured(folder.path(), "below.formula")["energy"], "cannot be told");
    // A value of 0/0 at the normal alone is no reason to doubt.
    write(&folder, "pole.formula", "formula; c = 1 - (N.L)*(N.L); = IL*<0.5*c/c>*max(0, N.L);");
    let found = measured(folder.path(), "pole.formula");
    assert_eq!((&found["conserves_energy"], &found["is_reciprocal"]), (&true.into(), &true.into()));
    assert_ne!(found["not_finite"], Value::Null);
}
