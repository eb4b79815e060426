"""Formats of other distributions, and formats that claim the same extension."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from support.command_line import done, refused, run

import fastlines as fl
from fastlines.errors import InputError
from fastlines.io import Format, known_formats
from fastlines.io.table import TABLE, by_word

#: A format of pairs of points: it reads text and writes it, and has an option.
PAIRS = textwrap.dedent(
    """
    import numpy as np
    import fastlines as fl
    from fastlines.io import Format

    FORMAT = Format(
        "pairs", (".pairs", ".prs"), "pairs of points", (b"PAIRS",), (fl.Lines,), "none", unit="mm", module=__name__
    )


    def read(source, invalid, *, scale: float = 1.0, note=None):
        numbers = source.data.removeprefix(b"PAIRS").split()
        if note:
            source.warn(note)
        if len(numbers) % 6:
            raise source.error(f"has {len(numbers)} numbers; expected six a line")
        return fl.Lines.from_segments(scale * np.reshape(numbers, (-1, 2, 3)).astype(np.float32), invalid=invalid)


    def write(lines, path):
        path.write_text("".join(" ".join(map(repr, row)) + chr(10) for row in lines.segments.reshape(-1, 6).tolist()))
        return ["the colour of the day"]
    """
)
FILE = b"0 0 0 1 0 0\n2 0 0 2 2 0\n"


@pytest.fixture
def install(install_format):
    """Install a distribution of one module with one object that should be a format."""

    def add(distribution, code):
        module = distribution.replace("-", "_")
        return install_format(distribution, code, {"format": f"{module}:FORMAT"})

    return add


def test_an_offset_is_subtracted_and_added_for_formats_of_others(install, tmp_path):
    install("fastlines-pairs", PAIRS)
    (tmp_path / "a.pairs").write_bytes(b"8000 0 0 8002 0 0\n")
    lines = fl.read(tmp_path / "a.pairs", offset="auto")
    assert (lines.offset, lines.segments[0, 0].tolist()) == ((8001.0, 0.0, 0.0), [-1, 0, 0])
    with pytest.warns(fl.FileWarning, match="the colour of the day"):
        fl.write(tmp_path / "b.pairs", lines)
    assert fl.read(tmp_path / "b.pairs").segments.tolist() == [[[8000, 0, 0], [8002, 0, 0]]]


def format_code(name, *extensions):
    return f"from fastlines.io import Format\nFORMAT = Format({name!r}, {extensions!r}, '', module=__name__)"


# --- Formats of others ---


def test_a_format_of_another_distribution_is_read_and_written(install, load, tmp_path):
    install("pairs-of-points", PAIRS)
    lines = load(FILE, "a.pairs")
    np.testing.assert_array_equal(lines.segments, [[[0, 0, 0], [1, 0, 0]], [[2, 0, 0], [2, 2, 0]]])
    assert lines.unit == "mm"
    assert load(FILE, "a.PRS", scale=2).segments.max() == 4
    for name, options in (("a.bin", {"format": "pairs"}), ("a.bin", {"format": ".prs"}), ("a.what", {})):
        assert len(load(b"PAIRS" + FILE if not options else FILE, name, **options)) == 2
    with pytest.raises(fl.FileFormatError, match=r"a\.pairs: has 1 numbers; expected six a line"):
        load(b"1", "a.pairs")
    with pytest.raises(InputError, match=r"the format 'pairs' has no option 'size'; .*known: scale, note"):
        load(FILE, "a.pairs", size=2)
    with pytest.raises(fl.FileFormatError, match=r"did you mean '\.pairs'\? known: .*\.trk.*\.prs"):
        load(FILE, "a.pair")
    with pytest.warns(fl.FileWarning, match="not kept, as the format has no place for it: the colour of the day"):
        fl.write(tmp_path / "b.pairs.gz", lines)
    np.testing.assert_array_equal(fl.read(tmp_path / "b.pairs.gz").segments, lines.segments)
    with pytest.raises(InputError, match=r"\.pairs files hold lines, this is a tree"):
        fl.build(lines).save(tmp_path / "a.pairs")


@pytest.mark.usefixtures("in_own_folder")
@pytest.mark.filterwarnings("always::fastlines.FileWarning")
def test_the_command_line_knows_it(install, tmp_path):
    install("pairs-of-points", PAIRS)
    (tmp_path / "a.pairs").write_bytes(FILE)
    assert done("info", "a.pairs").startswith("a.pairs: pairs of points")
    result = run("convert", "a.pairs", "b.prs", "--option", "scale=2", "--option", "note=42")
    assert result.stdout == "b.prs: pairs of points: 2 segments\n"
    assert "warning: a.pairs: 42\n" in result.stderr
    assert "no place for it: the colour of the day" in result.stderr
    assert fl.read("b.prs").segments.max() == 4
    assert "known: scale, note" in refused("info", "a.pairs", "--option", "size=2")[1]


def test_formats_are_found_on_first_use(install):
    folder = install("pairs-of-points", PAIRS)
    check = """if True:
        import sys
        sys.path.insert(0, sys.argv[1])
        import fastlines as fl
        fl.io
        assert not {"pairs_of_points", "importlib.metadata"} & sys.modules.keys()
        assert ".pairs" in fl.io.known_formats()
    """
    subprocess.run([sys.executable, "-c", check, str(folder)], check=True)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("import no_such_library", r"ModuleNotFoundError: No module named 'no_such_library'"),
        ("FORMATS = 1", "AttributeError: "),
        ("FORMAT = 'pairs'", r"TypeError: it is a str; expected a fastlines\.io\.Format"),
        (
            format_code("pairs", "pairs"),
            r"InputError: the format 'pairs' has the extension 'pairs'; expected one such as",
        ),
        (format_code("pairs", ".Pairs"), "in lower case"),
        (format_code("pairs", ".pairs.gz"), "the extension '.pairs.gz'"),
        (format_code("pairs", ".flt"), r"other than \.gz and \.flt"),
        (format_code("Pairs of points", ".pairs"), "the name of a format is 'Pairs of points'; expected lower-case"),
    ],
)
def test_a_broken_format_is_left_out(install, load, code, said):
    install("broken-pairs", code)
    install("pairs-of-points", PAIRS)
    words = f"the format 'format' of broken-pairs is left out, as its entry point 'broken_pairs:FORMAT' .*{said}"
    with pytest.warns(UserWarning, match=words):
        assert len(load(FILE, "a.pairs")) == 2
    assert len(load(FILE, "a.pairs")) == 2  # without a second warning


# --- Two formats that claim the same ---


@pytest.mark.parametrize(
    ("name", "extension", "claimed", "of"),
    [
        ("mine", ".trk", ".trk", "'trk' of fastlines"),
        ("mine", ".mmcif", ".mmcif", "'molecules' of fastlines"),
        ("trk", ".mine", "trk", "'trk' of fastlines"),
        ("mine", ".pairs", ".pairs", "'pairs' of pairs-of-points"),
    ],
)
def test_an_extension_that_another_format_has_is_refused(install, load, tmp_path, name, extension, claimed, of):
    install("pairs-of-points", PAIRS)
    install("z-mine", format_code(name, extension))
    both = {of, f"'{name}' of z-mine"}
    for use in (lambda: load(b"what?", "a.npy"), lambda: fl.write(tmp_path / "a.npz", np.zeros((1, 2, 3)))):
        with pytest.raises(InputError, match=f"^two formats claim '{re.escape(claimed)}': ") as error:
            use()
        said = str(error.value).partition("; uninstall ")
        assert set(said[0].partition(": ")[2].split(" and ")) == both
        assert said[2] in ("z-mine", "pairs-of-points")


def test_two_rows_of_the_table_may_not_claim_one_extension():
    rows = [("fastlines", row) for row in TABLE]
    assert set(by_word(rows).values()) == set(known_formats().values())
    with pytest.raises(
        InputError,
        match=r"^two formats claim '\.vtk': 'vtk' of fastlines and 'new' of fastlines; remove it from one of them$",
    ):
        by_word([*rows, ("fastlines", Format("new", (".new", ".vtk"), ""))])
