"""Sessions: pictures, values, drags, sweeps, hits."""

import threading
import time
import warnings

import illuminator
import numpy as np
import pytest

MATTE = """body_specific; kd: scalar, constraint 0..1, default 0.5, slider; formula; = kd*IL*Cd*max(0, N.L);"""
# A light far away on the axis of the camera, which looks at a large disc-like ball from far away.
BALL = """bodies; ball: sphere, center <0, 0, 0>, radius 1; lights; key: point, <0, 0, 1e6>;
camera; position <0, 0, 100>; gaze <0, 0, -1>; up <0, 1, 0>; fov 1.2;"""


def matte(**settings):
    settings = {"size": (64, 64), **settings}
    formula, scene = illuminator.Formula.parse(MATTE), illuminator.Scene.parse(BALL)
    return illuminator.Session(formula=formula, scene=scene, **settings)


@pytest.fixture
def studio():
    return illuminator.Session("preset:studio", size=(96, 72))


def test_a_picture_has_the_colours_of_the_model():
    session = matte(set={"ball.kd": 1, "ball.Cd": [0.5, 0.25, 1], "ka": 0, "background": [0, 0, 0.125]})
    picture = session.render()
    assert picture.shape == (64, 64, 3) and picture.dtype == np.float32
    assert picture.flags.c_contiguous and picture.flags.writeable
    # The middle of the ball faces camera and light.
    assert np.allclose(picture[31:33, 31:33], [0.5, 0.25, 1], atol=2e-3)
    assert np.allclose(picture[0, 0], [0, 0, 0.125])
    # At a distance of r from the middle, in radii, the cosine is sqrt(1 - r²).
    degrees = (np.arange(64) + 0.5 - 32) / 32 * 0.6
    radius = 100 * np.tan(np.radians(degrees))
    expected = np.sqrt(np.maximum(0, 1 - radius**2 - (100 * np.tan(np.radians(0.6 / 64)))**2))
    inside = expected > 0.3
    assert np.allclose(picture[32, inside, 2], expected[inside], atol=2e-2)


def test_both_backends_agree(studio):
    reference = illuminator.Session("preset:studio", size=(96, 72), backend="interpreter")
    assert np.allclose(studio.render(), reference.render(), atol=1e-4)


def test_passes_are_averaged():
    one, many = matte(), matte(samples=16)
    assert (one.samples, many.samples) == (1, 16)
    edges = lambda session: len(np.unique(session.render()[..., 0] > 0, axis=0))
    assert edges(one) and not np.array_equal(one.render(), many.render())
    # Where passes do not fit into the memory together, they are made one after the other.
    size = dict(size=(640, 480), samples=8)
    roomy, tight = matte(**size), matte(memory=40_000_000, **size)
    assert np.allclose(roomy.render(), tight.render(), atol=1e-6)
    with pytest.raises(illuminator.IlluminatorError, match="memory"):
        matte(memory=1000).render()


def test_images_are_what_files_hold(studio, tmp_path):
    image = studio.image()
    assert image.shape == (72, 96, 3) and image.dtype == np.uint8
    linear = np.clip(studio.render(), 0, 1)
    srgb = np.where(linear <= 0.0031308, 12.92*linear, 1.055*linear**(1 / 2.4) - 0.055)
    assert np.abs(image - srgb*255).max() <= 1
    studio.save(tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes() == studio._repr_png_()
    with pytest.raises(illuminator.IlluminatorError, match="names no format"):
        studio.save(tmp_path / "picture.tiff")


def test_values_are_set_and_read(studio):
    studio["ball.kd"] = 0.25
    studio.set("ball.ks=0.125")
    studio.set({"*.kr": 0.0625, "ball.Cd": "#ff8000"})
    assert studio["ball.kd"] == 0.25 and studio["ball.ks"] == 0.125
    assert studio["ball.kr"] == studio["floor.kr"] == 0.0625
    assert np.allclose(studio["ball.Cd"], [1, 128/255, 0], atol=1e-6)
    assert studio.values["ka"] == studio["ka"]
    with pytest.warns(illuminator.IlluminatorWarning, match="outside 0..1"):
        studio["ball.kd"] = 7
    assert studio["ball.kd"] + studio["ball.ks"] <= 1


def test_invariants_bind_sliders():
    session = illuminator.Session("preset:default", size=(32, 24))
    body = session.bodies[0]
    session.set({f"{body}.kd": 0.5, f"{body}.ks": 0.5})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        session.move(f"{body}.kd", 0.9)
    assert session[f"{body}.kd"] + session[f"{body}.ks"] <= 1 + 1e-6


@pytest.mark.parametrize("name, message", [
    ("bal.kd", "did you mean `ball`"),
    ("ball.kdd", "did you mean `kd`"),
    ("kd", "is a body parameter"),
    ("*.kd", "several"),
])
def test_names_that_do_not_exist_are_explained(studio, name, message):
    with pytest.raises(illuminator.IlluminatorError, match=message.replace("*", r"\*")):
        studio[name]


@pytest.mark.parametrize("name, value, message", [
    ("ball.kd", [1, 2, 3], "scalar"),
    ("ball.Cd", 0.5, "vector"),
    ("ball.kd", "much", "not a value"),
    ("ball.kd", None, "give `ball.kd` a value"),
    ("ball.kd", b"0.5", "cannot be bytes"),
    ("ball.kd", 1e300, "too large"),
    ("ball.kd", float("nan"), "not a value"),
    ("ball.kd=0.5", 0.5, "has a `=`"),
    ("ball.kd", {}, "a number, three numbers, or a text"),
])
def test_values_that_do_not_fit_are_explained(studio, name, value, message):
    before = studio.values
    with pytest.raises(illuminator.IlluminatorError, match=message):
        studio.set(name, value)
    assert str(studio.values) == str(before)


@pytest.mark.parametrize("settings, message", [
    ({"size": (0, 10)}, "`size` is .0, 10."),
    ({"size": (-1, 10)}, "width and height"),
    ({"memory": "much"}, "`memory` is 'much'"),
    ({"background": [1, 2]}, "`background`"),
    ({"set": ["ball.kd"]}, "names with values"),
    ({"formula": illuminator.Scene("preset:studio")}, "is no formula"),
    ({"samples": 0}, "samples"),
    ({"threads": 0}, "threads"),
    ({"threads": 1000000}, "threads"),
    ({"backend": "gpus"}, "there are \"jit\""),
    ({"materials": {"ball": "golde"}}, "golde"),
    ({"formula": "preset:phongg"}, "phongg"),
    ({"set": {"ball.kdd": 1}}, "kdd"),
])
def test_settings_that_do_not_fit_are_explained(settings, message):
    with pytest.raises(illuminator.IlluminatorError, match=message):
        illuminator.Session("preset:studio", **settings)


@pytest.mark.parametrize("session, name, values", [
    ("preset:studio", "ball.kd", (0.1, 0.7)),
    ("preset:studio", "ball.h", (5, 90)),
    ("preset:studio", "ball.Cd", ([1, 0, 0], [0.2, 0.9, 0.1])),
    ("preset:studio", "key.IL", ([1, 0, 0], [0.2, 0.9, 0.1])),
    ("preset:default", "ka", (0, 0.5)),
])
@pytest.mark.parametrize("samples", [1, 3])
def test_a_drag_gives_the_pictures_of_render(session, name, values, samples):
    held = illuminator.Session(session, size=(64, 48), samples=samples)
    with held.drag(name) as drag:
        for value in values:
            picture, image = drag(value), drag.image(value)
            assert np.allclose(picture, held.render(), atol=1e-5)
            assert np.abs(image.astype(int) - held.image()).max() <= 1
    assert np.allclose(held[name], values[-1], atol=1e-6)


def test_a_drag_follows_other_values(studio):
    with studio.drag("ball.kd") as drag:
        before = drag(0.5)
        studio["floor.kd"] = 0.1
        after = drag(0.5)
        assert not np.allclose(before, after) and np.allclose(after, studio.render(), atol=1e-5)
    with pytest.raises(illuminator.IlluminatorError, match="not held"):
        drag(0.5)
    with pytest.raises(illuminator.IlluminatorError, match="kdd"):
        studio.drag("ball.kdd")
    with studio.drag("ball.Cd") as drag, pytest.raises(illuminator.IlluminatorError, match="three numbers"):
        drag(0.5)


def test_a_sweep_has_the_pictures_of_its_values(studio):
    before = studio.values
    sweep = studio.sweep("ball.kd=0..0.5:3", "ball.h=5,50")
    assert len(sweep) == 6 and sweep.pictures.shape == (6, 72, 96, 3)
    assert [values["ball.kd"] for values in sweep.values][:2] == [0, 0]
    assert str(studio.values) == str(before)
    for values, picture in sweep:
        studio.set(values)
        assert np.allclose(picture, studio.render(), atol=1e-6)
    for wrong in ["ball.kd", "ball.kdd=0..1:3", "ball.kd=0..1:100001"]:
        with pytest.raises(illuminator.IlluminatorError):
            studio.sweep(wrong)
    with pytest.raises(illuminator.IlluminatorError, match="memory"):
        matte(memory=50_000_000, size=(512, 512)).sweep("ball.kd=0..1:1000")


def test_hits_shade_the_picture():
    session = matte(set={"ball.kd": 0.5, "ka": 0, "ball.Cd": [1, 1, 1]}, samples=2)
    hits = session.hits()
    normal = hits["hits.N"][hits["records.hit"]]
    cosine = np.maximum(0, np.einsum("ij,ij->i", normal, hits["records.L"]))
    pixel = hits["hits.pixel"][hits["records.hit"]]
    shaded = np.bincount(pixel, 0.5*cosine*hits["records.weight"], 64*64) / 2
    assert np.allclose(shaded.reshape(64, 64), session.render()[..., 0], atol=1e-5)
    assert set(hits["hits.pass"]) == {0, 1} and hits["misses.direction"].shape[1] == 3


def test_models_share_the_rays(studio):
    studio.render()
    other = studio.with_formula(illuminator.Formula.parse(MATTE))
    assert other["ball.kd"] == pytest.approx(studio["ball.kd"]) and other.bodies == studio.bodies
    fresh = illuminator.Session("preset:studio", size=(96, 72), formula=illuminator.Formula.parse(MATTE))
    assert np.array_equal(other.render(), fresh.render())


def test_a_session_is_saved_and_opened(studio, tmp_path):
    studio["ball.kd"] = 0.125
    studio.save_session(tmp_path / "mine.toml")
    again = illuminator.Session(tmp_path / "mine.toml")
    assert again["ball.kd"] == 0.125 and again.size == (96, 72)
    assert np.array_equal(again.render(), studio.render())


def test_other_threads_run_meanwhile():
    session = illuminator.Session("preset:default", size=(1280, 720))
    ticks = []
    running = True

    def tick():
        while running:
            ticks.append(time.monotonic())
            time.sleep(0.005)

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.monotonic()
    session.render()
    end = time.monotonic()
    running = False
    thread.join()
    during = [at for at in ticks if start < at < end]
    assert end - start < 0.02 or len(during) >= 2


def test_sessions_are_mappings_of_values(studio):
    assert "ball.kd" in studio and "ball.kdd" not in studio and 3 not in studio
    assert list(studio) == studio.keys() == list(studio.values)
    assert dict((name, studio[name]) for name in studio)["ball.kd"] == studio["ball.kd"]


def test_sliders_take_finite_numbers(studio):
    for value in [float("nan"), float("inf")]:
        with pytest.raises(illuminator.IlluminatorError, match="finite"):
            studio.move("ball.kd", value)

    class Half:
        """A number whose value depends on the session."""

        def __float__(self):
            return studio["ball.ks"] / 2

    studio["ball.ks"] = 0.25
    studio.move("ball.kd", Half())
    assert studio["ball.kd"] == 0.125


def test_values_are_read_while_a_picture_is_made():
    session = illuminator.Session("preset:default", size=(960, 540), samples=16)
    worker = threading.Thread(target=session.render)
    worker.start()
    time.sleep(0.05)
    start = time.monotonic()
    reads = 0
    while worker.is_alive():
        assert session.size == (960, 540) and "ka" in session.values and session.range("ka")
        reads += 1
    assert reads > 10 or time.monotonic() - start < 0.2
    worker.join()


def test_texts_without_a_file_are_not_saved(tmp_path):
    for name in ["mine.formula", "preset:phong"]:
        formula = illuminator.Formula.parse("formula;\n= Cd;", name=name)
        session = illuminator.Session("preset:studio", formula=formula)
        with pytest.raises(illuminator.IlluminatorError, match="does not hold it"):
            session.save_session(tmp_path / "mine.toml")
    with pytest.raises(illuminator.IlluminatorError, match="cannot write"):
        illuminator.Session("preset:studio").save_session(tmp_path / "nowhere/mine.toml")


def test_hits_keep_to_the_memory():
    with pytest.raises(illuminator.IlluminatorError, match="the hits take"):
        illuminator.Session("preset:studio", size=(320, 240), samples=8, memory=60e6).hits()


def test_a_sweep_warns_of_a_few_values(studio):
    with pytest.warns(illuminator.IlluminatorWarning) as found:
        studio.variations("ball.kd=2..3:60")
    assert len(found) == 6 and "more values are not used" in str(found[-1].message)


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="there is no fork")
def test_forked_processes_are_told_to_spawn(studio):
    import os

    studio.render()
    child = os.fork()
    if child == 0:
        try:
            studio.render()
        except illuminator.IlluminatorError as error:
            os._exit(7 if "spawn" in str(error) else 1)
        os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
