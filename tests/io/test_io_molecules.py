"""Molecules: bonds that are listed and those by distance, models, alternate places, and bad files."""

from __future__ import annotations

import contextlib
import re
import sys

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.errors import FastlinesError, MissingExtraError
from fastlines.io.formats import bonds
from fastlines.io.formats.bonds import CrowdedError, bonded

pytest.importorskip("gemmi")


def atom(serial, name, residue, chain, number, x, y, z, element, alt=" ", record="ATOM  ", b=10.0):
    return (
        f"{record}{serial:5d} {name:<4}{alt}{residue:>3} {chain}{number:4d}    "
        f"{x:8.3f}{y:8.3f}{z:8.3f}{1.0:6.2f}{b:6.2f}          {element:>2}"
    )


def link(name, residue, other, other_residue, symmetry):
    return f"LINK        {name}{residue}{'':16}{other}{other_residue}     1555   {symmetry}  3.50"


#: Two residues with hydrogens, an alternate place, water, and zinc, which LINK and CONECT join to far atoms.
PDB = "\n".join(
    [
        link("ZN   ", " ZN B   1", " OD1A", "ASP A   2", "1555"),
        link("ZN   ", " ZN B   1", " CA  ", "GLY A   1", "2555"),
        atom(1, " N  ", "GLY", "A", 1, 0, 0, 0, "N", b=1),
        atom(2, " CA ", "GLY", "A", 1, 1.46, 0, 0, "C", b=2),
        atom(3, " HA ", "GLY", "A", 1, 1.46, 1.09, 0, "H"),
        atom(4, " C  ", "ASP", "A", 2, 2.9, 0, 0, "C"),
        atom(5, " OD1", "ASP", "A", 2, 2.9, 1.23, 0, "O", alt="A"),
        atom(6, " OD1", "ASP", "A", 2, 2.9, 0.6, 1.0, "O", alt="B"),
        atom(7, "ZN  ", " ZN", "B", 1, 2.9, 4.5, 0, "ZN", record="HETATM"),
        atom(8, " O  ", "HOH", "B", 2, 9, 9, 9, "O", record="HETATM"),
        atom(9, " H1 ", "HOH", "B", 2, 9.96, 9, 9, "H", record="HETATM"),
        atom(10, " O  ", "HOH", "B", 3, 19, 9, 9, "O", record="HETATM"),
        "CONECT    7    8",
        "CONECT    8    7",
        "END",
    ]
)
#: The numbers of the atoms that are bonded.
BONDS = {(1, 2), (2, 3), (2, 4), (4, 5), (4, 6), (8, 9), (5, 7), (7, 8)}


def places(text):
    """Return the serial number of the atom at each place."""
    rows = [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]
    return {tuple(np.float32(row[30:54].split()).tolist()): int(row[6:11]) for row in rows}


def bonds_of(lines, at):
    return {tuple(sorted(at[tuple(end)] for end in ends)) for ends in lines.segments.tolist()}


@pytest.mark.parametrize("name", ["a.pdb", "a.ent", "a.pdb.gz"])
def test_bonds(load, name):
    import gzip

    data = PDB.encode()
    lines = load(gzip.compress(data) if name.endswith(".gz") else data, name)
    assert bonds_of(lines, places(PDB)) == BONDS
    assert len(lines) == len(BONDS)
    row = {tuple(sorted(places(PDB)[tuple(end)] for end in ends)): i for i, ends in enumerate(lines.segments.tolist())}
    assert {bond for bond in BONDS if lines.attributes["listed"][row[bond]]} == {(5, 7), (7, 8)}
    assert (lines.unit, lines.up, lines.radius) == ("Å", None, None)
    first, far = row[1, 2], row[5, 7]
    assert lines.end_attributes["element"][first].tolist() == [7, 6]
    assert lines.end_attributes["b_factor"][first].tolist() == [1, 2]
    assert lines.end_attributes["chain"][far].tolist() == [0, 1]
    assert lines.end_attributes["residue"][row[2, 4]].tolist() == [1, 2]
    assert lines.strands[[first, far, row[7, 8]]].tolist() == [0, 0, 1]
    ends = {name: lines.end_attributes[name] for name in ("atom", "name", "chain_name", "residue_name")}
    assert ends["atom"][far].tolist() == [4, 6]
    assert ends["name"][far].tolist() == ["OD1", "ZN"]
    assert (ends["chain_name"][far].tolist(), ends["residue_name"][far].tolist()) == (["A", "B"], ["ASP", "ZN"])


def test_atoms_count_in_the_order_of_the_file(load):
    """Chains that go on behind another one are joined, but the atoms keep their numbers."""
    rows = [line for line in PDB.splitlines() if line.startswith(("ATOM", "HETATM"))]
    rows = [*rows[3:6], *rows[6:], *rows[:3]]
    lines = load("\n".join(rows).encode(), "a.pdb")
    assert len(lines) == 6
    points = np.float32([row[30:54].split() for row in rows])
    assert (points[lines.end_attributes["atom"]] == lines.segments).all()
    assert lines.end_attributes["name"].tolist() == [
        [rows[i][12:16].strip() for i in pair] for pair in lines.end_attributes["atom"]
    ]
    hits = fl.build(lines).first_hit([0.2, 0, -9], [0, 0, 1], 0.1)
    assert hits.sample("atom") == 7 + 0  # the end that is nearer: N, behind the other seven
    assert lines.end_attributes["name"][hits.prim, round(float(hits.u))] == "N"


def test_listed_bonds_of_missing_atoms(load):
    with pytest.warns(fl.FileWarning, match="1 bonds that it lists are of atoms that this model does not have"):
        load(PDB.replace(" OD1A", " OX1A", 1).encode(), "a.pdb")


def test_tolerance_and_models(load):
    far = atom(1, " C  ", "GLY", "A", 1, 0, 0, 0, "C"), atom(2, " C  ", "GLY", "A", 1, 1.95, 0, 0, "C")
    text = "MODEL        1\n" + "\n".join(far) + "\nENDMDL\nMODEL        2\n" + PDB.partition("3.50\nATOM")[2]
    text = text.replace("MODEL        2\n", "MODEL        2\nATOM")
    with pytest.warns(fl.FileWarning, match="its 2 atoms are not read, as no bond joins them"):
        assert len(load(text.encode(), "a.pdb")) == 0
    assert len(load(text.encode(), "a.pdb", tolerance=0.5)) == 1
    assert len(load(text.encode(), "a.pdb", model=2)) == len(BONDS) - 1  # without LINK
    assert bonds_of(load(PDB.encode(), "a.pdb", tolerance=-1), places(PDB)) == {(5, 7), (7, 8)}
    with pytest.raises(FastlinesError, match="has 2 models; expected 3 or more for model=3"):
        load(text.encode(), "a.pdb", model=3)
    for options in ({"model": 0}, {"model": "x"}, {"tolerance": 11}, {"tolerance": float("nan")}):
        with pytest.raises(fl.InputError, match=next(iter(options))):
            load(text.encode(), "a.pdb", **options)


CIF = """data_A
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.B_iso_or_equiv
ATOM 1 N N . GLY A 1 0 0 0 1.5
ATOM 2 C CA . GLY A 1 1.46 0 0 2.5
ATOM 3 C CB . GLY B 1 1.46 3.0 0 2.5
loop_
_struct_conn.id
_struct_conn.conn_type_id
_struct_conn.ptnr1_label_asym_id
_struct_conn.ptnr1_label_comp_id
_struct_conn.ptnr1_label_seq_id
_struct_conn.ptnr1_label_atom_id
_struct_conn.ptnr2_label_asym_id
_struct_conn.ptnr2_label_comp_id
_struct_conn.ptnr2_label_seq_id
_struct_conn.ptnr2_label_atom_id
1 covale A GLY 1 CA B GLY 1 CB
2 hydrog A GLY 1 N B GLY 1 CB
"""


@pytest.mark.parametrize("name", ["a.cif", "a.mmcif", "a.pdb"])
def test_mmcif(load, name):
    lines = load(CIF.encode(), name)
    assert lines.segments.tolist() == np.float32([[[0, 0, 0], [1.46, 0, 0]], [[1.46, 0, 0], [1.46, 3, 0]]]).tolist()
    assert lines.attributes["listed"].tolist() == [False, True]
    assert lines.end_attributes["b_factor"].tolist() == [[1.5, 2.5], [2.5, 2.5]]
    text = CIF.replace("GLY B 1 1.46", "GLY B 1 ?")
    assert "row 1" in message_of(load, text.encode(), name, fl.InputError)
    assert len(load(text.encode(), name, invalid="skip")) == 1


def test_all_pairs_by_brute_force():
    rng = np.random.default_rng(5)
    for n, size in ((2, 1), (300, 8), (300, 60), (40, 1000)):
        points, radii = rng.random((n, 3)) * size - size / 3, rng.uniform(0.3, 1.4, n)
        alternate = rng.choice(np.uint8([0, 0, 65, 66]), n)
        i, j = np.triu_indices(n, 1)
        distance = np.linalg.norm(points[i] - points[j], axis=1)
        good = (distance > 0.4) & (distance < radii[i] + radii[j] + 0.45)
        good &= (alternate[i] == alternate[j]) | (alternate[i] == 0) | (alternate[j] == 0)
        found = bonded(points, radii, alternate, 0.45)
        assert sorted(map(tuple, found.tolist())) == sorted(zip(i[good].tolist(), j[good].tolist(), strict=True))


def test_crowds_and_deserts():
    n = 5000
    for points in (
        np.zeros((n, 3)),
        np.linspace(0, 1e9, n)[:, None] * np.ones(3),
        np.float64([[0, 0, 0], [1e300] * 3]),
    ):
        with pytest.raises(CrowdedError):
            bonded(points, np.ones(len(points)), np.zeros(len(points), np.uint8), 0.45)
    assert len(bonded(np.full((4, 3), np.nan), np.ones(4), np.zeros(4, np.uint8), 0.45)) == 0


@pytest.mark.parametrize("n", [2, 30])
def test_atoms_may_have_many_neighbours_but_not_all(monkeypatch, n):
    # All n atoms are in one cell, so there are n² pairs.
    points = np.linspace(0, 1, n)[:, None] * np.float64([1, 0, 0])
    arguments = points, np.ones(n), np.zeros(n, np.uint8), 0.45
    expected = bonded(*arguments)
    monkeypatch.setattr(bonds, "_MORE", 0)
    monkeypatch.setattr(bonds, "_MAX_NEAR", n)
    np.testing.assert_array_equal(bonded(*arguments), expected)
    monkeypatch.setattr(bonds, "_MAX_NEAR", n - 1)
    with pytest.raises(CrowdedError, match="packed too densely"):
        bonded(*arguments)
    monkeypatch.setattr(bonds, "_MORE", n)
    np.testing.assert_array_equal(bonded(*arguments), expected)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.pdb", "oak", "holds no atoms; expected a molecule"),
        (
            "a.pdb",
            PDB.replace("   0.000   0.000   0.000", "   0.000     oak   0.000", 1),
            "line 3: columns 31 to 54 .*'",
        ),
        ("a.pdb", PDB[:200], "line 3: columns 31 to 54|holds no atoms"),
        ("a.cif", "data_a\nloop_\n_atom_site_label\n_atom_site_fract_x\nC 0.1\n", "a crystal of small molecules"),
        ("a.cif", "data_a\n_cell.length_a 1\n", "holds no atoms ._atom_site."),
        ("a.cif", "data_a\nloop_\n_atom_site.Cartn_x\n", "holds no atoms; expected a molecule"),
        ("a.cif", "data_a\nloop_\n_atom_site.Cartn_x\n'oak", "cannot be read as mmCIF"),
    ],
)
def test_bad_files(load, name, text, said):
    message = message_of(load, text.encode(), name)
    assert re.search(said, message), message


def test_without_the_library(load, monkeypatch):
    monkeypatch.setitem(sys.modules, "gemmi", None)
    with pytest.raises(MissingExtraError, match=r"reading molecules needs .*the extra 'molecules'"):
        load(PDB.encode(), "a.pdb")


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("name", ["a.pdb", "a.cif"])
def test_damaged_text(load, name):
    for data in mutations((PDB if name == "a.pdb" else CIF).encode(), 400):
        with contextlib.suppress(FastlinesError):
            lines = load(data, name, invalid="skip")
            assert len(lines.strands) == len(lines.segments)
