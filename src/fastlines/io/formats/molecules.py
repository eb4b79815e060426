"""Molecules (``.pdb``, ``.ent``, ``.cif``, ``.mmcif``): bonds as segments, by gemmi (the extra "molecules").

Formats: https://www.wwpdb.org/documentation/file-format (PDB 3.3) and https://mmcif.wwpdb.org (PDBx/mmCIF).

Bonds are those that the file lists (CONECT, LINK, SSBOND, ``_struct_conn``, but no hydrogen bonds and none to copies by
symmetry), and those that distances show, for files list few: `bonds` has the rule. Hydrogen atoms take part where the
file has them. Bonds between alternate places of atoms are left out. Atoms without bonds, such as ions and most waters,
have no segment. A strand is a chain. Sticks have no radius of their own.

Attributes of both ends are ``atom`` (the number of the atom, from 0 in the order of the model in the file), its
``name``, ``element`` (the atomic number), ``b_factor`` (Å²), ``chain`` and ``residue`` (their numbers: chains counted
from 0, residues as in the file), ``chain_name`` and ``residue_name``. ``listed`` says whether the file lists the bond.
Occupancies, anisotropic displacements and everything beside atoms and bonds are dropped.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arrays import IntArray, count, number
from ...errors import FileFormatError
from ...geometry.lines import Lines
from ...geometry.strand_attributes import objects
from ...support.optional import optional
from ..source import Source, reason
from .bonds import CrowdedError, bonded
from .number_text import unify

_CIF = re.compile(r"(?:\s|#[^\n]*+\n)*+(?:data_|global_|loop_)", re.IGNORECASE)
#: Types of listed connections that are bonds.
_BONDS = ("Covale", "Disulf", "MetalC", "Unknown")


def read(source: Source, invalid: str, *, model: int = 1, tolerance: float = 0.45) -> Lines:
    """Read the bonds of one model.

    Parameters
    ----------
    model : int
        Which model, counted from 1.
    tolerance : float
        Atoms are bonded that are nearer than the sum of their covalent radii and this, in Å. With a negative number,
        only the bonds that the file lists are read.
    """
    model = count("model", model, 1)
    tolerance = number("tolerance", tolerance, "a length in Å, -1 to 10", -1, 10)
    gemmi = optional("gemmi", "reading molecules", "molecules")
    structure = _structure(source, gemmi)
    if model > len(structure):
        raise source.error(f"has {len(structure)} models; expected {model} or more for model={model}")
    serials = _number_atoms(structure[model - 1])
    structure.merge_chain_parts()
    atoms = _atoms(source, structure[model - 1], serials)

    # Join the bonds of the file and those by distance.
    listed = _listed(source, gemmi, structure, structure[model - 1], atoms)
    near = np.empty((0, 2), np.int64)
    if tolerance >= 0:
        try:
            near = bonded(atoms.points, atoms.radii, atoms.places, tolerance)
        except CrowdedError as error:
            raise source.error(f"{error}; its coordinates are damaged") from None
    if not len(listed) and not len(near):
        source.warn(f"its {len(atoms.points)} atoms are not read, as no bond joins them")
    bonds, where = np.unique(np.concatenate([listed, near]), axis=0, return_index=True)
    return Lines.from_segments(
        atoms.points[bonds],
        strands=atoms.ends["chain"][bonds[:, 0]].astype(np.int64),
        end_attributes={name: values[bonds] for name, values in atoms.ends.items()},
        attributes={"listed": where < len(listed)},
        offset=source.offset,
        invalid=invalid,
    )


def _structure(source: Source, gemmi: Any) -> Any:
    """Parse the file, in the format that it is in."""
    text = unify(source.text().encode("ascii", "replace")).decode("ascii")  # names may hold anything
    is_cif = _CIF.match(text) is not None
    try:
        if not is_cif:
            _check_pdb(source, text)
            structure = gemmi.read_pdb_string(text)
        else:
            document = gemmi.cif.read_string(text)
            blocks = [block for block in document if block.find_loop("_atom_site.Cartn_x")]
            blocks = blocks or [block for block in document if block.find_value("_atom_site.Cartn_x")]
            if not blocks:
                small = any(block.find_loop("_atom_site_fract_x") for block in document)
                kind = "a crystal of small molecules (_atom_site_fract_x)" if small else "no atoms (_atom_site)"
                raise source.error(f"holds {kind}; expected PDBx/mmCIF with _atom_site.Cartn_x: convert it")
            structure = gemmi.make_structure_from_block(blocks[0])
    except FileFormatError:
        raise
    except Exception as error:  # the library raises many types for damaged files
        kind = "mmCIF" if is_cif else "PDB"
        raise source.error(f"cannot be read as {kind}: {reason(error)}; get a fresh copy, or fix it") from None
    if not len(structure) or not structure[0].count_atom_sites():
        raise source.error("holds no atoms; expected a molecule in the format PDB or PDBx/mmCIF")
    return structure


def _check_pdb(source: Source, text: str) -> None:
    """Refuse coordinates that are not numbers, for which the library takes 0."""
    for i, line in enumerate(text.splitlines(), start=1):
        if line.startswith(("ATOM  ", "HETATM")):
            try:
                for at in (30, 38, 46):
                    float(line[at : at + 8])
            except ValueError:
                raise source.error(
                    f"line {i}: columns 31 to 54 of an atom, {line[30:54]!r}, are not three numbers; fix it"
                ) from None


@dataclass(frozen=True)
class _Atoms:
    """Arrays with one row for each atom of a model.

    Attributes
    ----------
    points : (n, 3) float64
    radii : (n,) float64
        Covalent radii, in Å.
    places : (n,) uint8
        The letter of an alternate place; 0 for atoms with one place.
    serials : (n,) int64
    ends : dict of str to (n,) array
        The attributes.
    """

    points: npt.NDArray[np.float64]
    radii: npt.NDArray[np.float64]
    places: npt.NDArray[np.uint8]
    serials: IntArray
    ends: dict[str, npt.NDArray[Any]]


def _number_atoms(model: Any) -> IntArray:
    """Replace the serial numbers of atoms by their place in the model, from 0; return the former ones."""
    serials = []
    for chain in model:
        for residue in chain:
            for atom in residue:
                serials.append(atom.serial)
                atom.serial = len(serials) - 1
    return np.array(serials, np.int64)


def _atoms(source: Source, model: Any, serials: IntArray) -> _Atoms:
    rows = []
    names: list[tuple[str, str, str]] = []
    for i, chain in enumerate(model):
        for residue in chain:
            n = residue.seqid.num
            for atom in residue:
                at, element = atom.pos, atom.element
                names.append((atom.name, chain.name, residue.name))
                rows.append(
                    (at.x, at.y, at.z, element.covalent_r, ord(atom.altloc), atom.serial, element.atomic_number,
                     atom.b_iso, i, n if n is not None else -1)
                )  # fmt: skip
    if not rows:
        raise source.error("this model of it holds no atoms")
    table = np.array(rows, np.float64)
    columns = {"element": (6, np.uint8), "b_factor": (7, np.float32), "chain": (8, np.int32), "residue": (9, np.int32)}
    with np.errstate(invalid="ignore", over="ignore"):
        ends = {name: table[:, at].astype(dtype) for name, (at, dtype) in columns.items()}
    atom = table[:, 5].astype(np.int64)
    texts = zip(("name", "chain_name", "residue_name"), zip(*names, strict=True), strict=True)
    ends = {"atom": atom, **ends, **{name: objects(column) for name, column in texts}}
    return _Atoms(table[:, :3].copy(), table[:, 3].copy(), table[:, 4].astype(np.uint8), serials[atom], ends)


def _listed(source: Source, gemmi: Any, structure: Any, model: Any, atoms: _Atoms) -> IntArray:
    """Return the pairs of atoms whose bonds the file lists, (n, 2), the lower number first."""
    row_of = {serial: row for row, serial in enumerate(atoms.serials.tolist())}
    row_of_atom = {atom: row for row, atom in enumerate(atoms.ends["atom"].tolist())}
    pairs: set[tuple[int, int]] = set()
    excluded: set[tuple[int, int]] = set()
    n_missing = 0
    for connection in structure.connections:
        ends = [model.find_cra(partner).atom for partner in (connection.partner1, connection.partner2)]
        if None in ends:
            n_missing += 1
            continue
        pair = (row_of_atom[ends[0].serial], row_of_atom[ends[1].serial])
        is_bond = connection.type.name in _BONDS and connection.asu != gemmi.Asu.Different
        (pairs if is_bond else excluded).add((min(pair), max(pair)))
    if n_missing:
        source.warn(f"{n_missing} bonds that it lists are of atoms that this model does not have")
    for serial, others in structure.conect_map.items():
        for other in others:
            if serial in row_of and other in row_of:
                pair = (row_of[serial], row_of[other])
                pairs.add((min(pair), max(pair)))
    return np.array(sorted(pair for pair in pairs - excluded if pair[0] != pair[1]), np.int64).reshape(-1, 2)
