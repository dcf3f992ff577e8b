"""Formulas, scenes and what is wrong with them."""

import pickle

import illuminator
import numpy as np
import pytest

ALL = illuminator.presets()


@pytest.mark.parametrize("name", ALL["formula"])
def test_every_built_in_formula_has_a_finite_lobe(name):
    formula = illuminator.Formula(f"preset:{name}")
    angle = np.linspace(-1.5, 1.5, 31)
    light = np.stack([np.sin(angle), 0*angle, np.cos(angle)], axis=-1)
    lobe = formula(L=light, V=[0.6, 0, 0.8])
    assert lobe.shape == (31, 3) and np.isfinite(lobe).all()


def test_a_formula_is_a_function_of_directions():
    formula = illuminator.Formula.parse(
        "body_specific; n: scalar, constraint 1..100, default 2; formula; S = max(0, R.V)^n; = S*IL + <alpha, beta, gamma>;"
    )
    light, view = np.array([0.6, 0, 0.8]), np.array([0, 0.6, 0.8])
    mirrored = [-0.6, 0, 0.8]
    cosine = mirrored @ view
    assert formula(of="S", L=light, V=view, n=3) == pytest.approx(cosine**3, rel=1e-5)
    angles = np.arccos([0.8, cosine, 0.8])
    assert np.allclose(formula(L=light, V=view), cosine**2 + angles, atol=1e-6)
    # Arrays broadcast.
    grid = formula(of="S", L=light, V=np.tile(view, (5, 1, 1)), n=np.arange(1, 4))
    assert grid.shape == (5, 3) and np.allclose(grid, cosine**np.arange(1, 4), rtol=1e-5)
    assert formula(L=np.zeros((0, 3)), V=view).shape == (0, 3)


@pytest.mark.parametrize("given, message", [
    ({"L": [0, 0, 1]}, "`R`|`V`|beta"),
    ({"V": [0, 0, 1]}, "give directions"),
    ({"L": [0, 1], "V": [0, 0, 1]}, "last axis"),
    ({"L": [0, 0, 1], "V": [0, 0, 1], "m": 3}, "no parameter"),
    ({"L": [0, 0, 1], "V": [0, 0, 1], "n": "three"}, "not a text"),
    ({"L": [0, 0, 1], "V": [0, 0, 1], "of": "T"}, "no macro"),
])
def test_arguments_that_do_not_fit_are_explained(given, message):
    formula = illuminator.Formula.parse("body_specific; n: scalar; formula; S = max(0, R.V)^n; = S*IL + <beta>;")
    with pytest.raises(illuminator.IlluminatorError, match=message):
        formula(**given)


def test_arguments_may_be_any_arrays_colours_and_lengths():
    formula = illuminator.Formula("preset:phong")
    plain = formula(L=[0.6, 0, 0.8], V=[0, 0, 1], Cd=[1, 0, 0])
    assert np.allclose(formula(L=[3, 0, 4], V=[0, 0, 0.1], Cd="#ff0000"), plain, rtol=1e-6)
    unaligned = np.frombuffer(b"x" + np.float32([0.6, 0, 0.8]).tobytes(), np.float32, offset=1)
    assert np.array_equal(formula(L=unaligned, V=[0, 0, 1], Cd=[1, 0, 0]), plain)
    with pytest.raises(illuminator.IlluminatorError, match="None"):
        formula(L=[0, 0, 1], V=[0, 0, 1], kd=None)
    with pytest.raises(illuminator.IlluminatorError, match="#rrggbb"):
        formula(L=[0, 0, 1], V=[0, 0, 1], Cd="red")


def test_arrays_of_different_shapes_are_an_error():
    with pytest.raises(ValueError):
        illuminator.Formula("preset:phong")(L=np.ones((3, 3)), V=np.ones((4, 3)))


def test_errors_have_places():
    with pytest.raises(illuminator.TextError) as raised:
        illuminator.Formula.parse("formula;\n= IL*Cb*max(0, N.L) + Q;", name="mine.formula")
    assert (raised.value.file, raised.value.line, raised.value.column) == ("mine.formula", 2, 6)
    first, second = raised.value.diagnostics
    assert (first.severity, first.file, first.line, first.column) == ("error", "mine.formula", 2, 6)
    assert (first.places[0].end_line, first.places[0].end_column) == (2, 8)
    assert second.line == 2 and "Q" in second.message
    assert "= IL*Cb*max(0, N.L)" in str(raised.value) and "^^" in str(raised.value)
    with pytest.raises(illuminator.TextError) as raised:
        illuminator.Scene.parse("bodies; ball: spher; lights; camera;")
    assert any("sphere" in help for found in raised.value.diagnostics for help in found.help + [found.message])
    with pytest.raises(illuminator.IlluminatorError, match="nowhere"):
        illuminator.Formula("nowhere.formula")
    for read in [illuminator.Formula, lambda text: illuminator.Session(formula=text)]:
        with pytest.raises(illuminator.IlluminatorError, match=r"use `(illuminator\.)?Formula\.parse"):
            read("formula; = Cd;")


def test_checking_lists_errors_and_warnings():
    assert illuminator.check("formula; = IL*Cd*max(0, N.L);") == []
    assert [found.severity for found in illuminator.check("formula; = Cd*N.L;")] == ["error"]
    assert {found.severity for found in illuminator.check("formula; Q = 1; = Cd;")} == {"warning"}
    assert illuminator.check("bodies; lights; camera;", kind="scene")
    for wrong in [{"kind": "poem"}, {}]:
        with pytest.raises(illuminator.IlluminatorError):
            illuminator.check("once upon a time", **wrong)


def test_warnings_of_texts_are_given():
    with pytest.warns(illuminator.IlluminatorWarning, match="Q"):
        illuminator.Formula.parse("formula; Q = 1; = Cd;")


def test_parameters_are_described():
    formula = illuminator.Formula.parse("""body_specific;
kd: scalar, constraint 0..1, default 0.25, slider;   // matte part
model: scalar, choices "GGX", "Beckmann";
formula; = kd*Cd*if(model == 1, 1, 2)*IL;""")
    own = {parameter.name: parameter for parameter in formula.parameters if not parameter.predefined}
    kd, model = own["kd"], own["model"]
    assert (kd.owner, kd.type, kd.range, kd.default, kd.slider, kd.doc) == ("body", "scalar", (0, 1), 0.25, True, "matte part")
    assert model.choices == ["GGX", "Beckmann"] and not model.slider
    direction = dict(L=[0, 0, 1], V=[0, 0, 1])
    assert np.allclose(formula(model="Beckmann", **direction)*2, formula(model="GGX", **direction))


def test_formulas_are_exported():
    assert "float" in illuminator.Formula("preset:phong").export("glsl", name="mine")
    with pytest.raises(illuminator.IlluminatorError, match='"wgsl"'):
        illuminator.Formula("preset:phong").export("fortran")


def test_formulas_and_scenes_go_to_other_processes():
    with pytest.raises(illuminator.TextError) as raised:
        illuminator.Formula.parse("formula; = Cb;")
    error = pickle.loads(pickle.dumps(raised.value))
    assert isinstance(error, illuminator.TextError) and error.diagnostics[0].column == raised.value.column == 12
    assert [str(found) for found in error.diagnostics] == [str(found) for found in raised.value.diagnostics]
    for text in [illuminator.Formula("preset:phong"), illuminator.Scene("preset:studio")]:
        again = pickle.loads(pickle.dumps(text))
        assert (again.text, again.name) == (text.text, text.name)
