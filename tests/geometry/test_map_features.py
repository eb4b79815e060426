"""Lines from geometries of shapely and tables of geopandas."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.errors import FileWarning, InputError

shapely = pytest.importorskip("shapely")

FLAT = shapely.LineString([[0, 0], [1, 1], [2, 1]])
RING = shapely.LinearRing([[0, 0, 1], [1, 1, 2], [2, 1, 3]])
HOLED = shapely.Polygon([[0, 0], [9, 0], [0, 9]], [[[1, 1], [2, 1], [1, 2]]])
SEVERAL = shapely.MultiLineString([[[5, 5], [6, 6]], [[7, 7], [8, 8]]])
MIXED = shapely.GeometryCollection([HOLED, shapely.GeometryCollection([SEVERAL, shapely.Point(0, 0)]), FLAT])


def points_of(lines):
    """Return the points of each strand."""
    found = []
    for strand in np.unique(lines.strands):
        ends = lines.segments[lines.strands == strand]
        assert (ends[1:, 0] == ends[:-1, 1]).all()
        found.append([*ends[:1, 0].tolist(), *ends[:, 1].tolist()])
    return found


def test_one_geometry():
    assert points_of(fl.lines(FLAT)) == [[[0, 0, 0], [1, 1, 0], [2, 1, 0]]]
    assert points_of(fl.lines(RING)) == [[[0, 0, 1], [1, 1, 2], [2, 1, 3], [0, 0, 1]]]
    assert points_of(fl.lines(SEVERAL)) == [[[5, 5, 0], [6, 6, 0]], [[7, 7, 0], [8, 8, 0]]]
    outer, inner = points_of(fl.lines(HOLED))
    assert outer == [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 0]]
    assert inner == [[1, 1, 0], [2, 1, 0], [1, 2, 0], [1, 1, 0]]
    assert len(fl.lines(shapely.LineString())) == 0
    with pytest.warns(FileWarning, match="without a line are not read: 1 Point"):
        lines = fl.lines(MIXED)
    assert points_of(lines) == [outer, inner, *points_of(fl.lines(SEVERAL)), *points_of(fl.lines(FLAT))]
    assert set(lines.attributes["feature"].tolist()) == {0}
    assert fl.build(RING).first_hit([1.5, 1, -1], [0, 0, 1], 0.1).prim == 1


@pytest.mark.parametrize("kind", [list, tuple, iter, lambda items: np.array(items, object)])
def test_several_geometries(kind):
    with pytest.warns(FileWarning, match="1 None, 1 Point") as told:
        lines = fl.lines(kind([FLAT, None, MIXED, shapely.LineString(), RING]))
    assert told[0].filename == __file__
    strand_features = lines.attributes["feature"][np.unique(lines.strands, return_index=True)[1]]
    assert strand_features.tolist() == [0, 2, 2, 2, 2, 2, 4]
    assert lines.strands[-1] == 6
    with pytest.raises(InputError, match="item 1 is a list; expected a geometry of shapely"):
        fl.lines([FLAT, [[0, 0, 0], [1, 1, 1]]])


def test_coordinates_that_cannot_be_used():
    with np.errstate(invalid="ignore"):
        bad = shapely.linestrings([[0, 0], [1, np.nan], [2, 2]], handle_nan="allow")
    with pytest.raises(InputError, match="NaN"):
        fl.lines([FLAT, bad])
    assert fl.lines([FLAT, bad], invalid="skip").attributes["feature"].tolist() == [0, 0]
    with pytest.warns(fl.PrecisionWarning):
        fl.lines(shapely.LineString([[16e6, 48e6], [16e6 + 0.1, 48e6]]))


def test_tables():
    geopandas = pytest.importorskip("geopandas")
    table = geopandas.GeoDataFrame(
        {
            "name": ["a", None, "c"],
            "n": [1, 2, 3],
            "part": np.array([1.5, np.nan, 2], object),
            "radius": [0.25, 0.5, 0.75],
            "other": [{}, [], None],
            "geometry": [FLAT, SEVERAL, RING],
        },
        index=[7, 8, 9],
        crs=25832,
    )
    with pytest.warns(FileWarning, match="columns that hold neither numbers nor texts are not kept: 'other'"):
        lines = fl.lines(table)
    assert lines.attributes["feature"].tolist() == [0, 0, 1, 1, 2, 2, 2]
    assert lines.attributes["name"].tolist() == ["a", "a", "", "", "c", "c", "c"]
    assert lines.attributes["n"].tolist() == [1, 1, 2, 2, 3, 3, 3]
    np.testing.assert_array_equal(lines.attributes["part"], [1.5, 1.5, np.nan, np.nan, 2, 2, 2])
    assert lines.radius.tolist() == [0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 0.75]
    assert (lines.unit, lines.up) == ("m", "z")
    hit = fl.build(lines).first_hit([6, 6, -1], [0, 0, 1])
    assert table.iloc[lines.attributes["feature"][hit.prim]].geometry is SEVERAL
    assert fl.lines(table.geometry).unit == "m"
    series = geopandas.GeoSeries([FLAT, RING], crs=4326)
    for given in (series, series.values):
        lines = fl.lines(given)
        assert (lines.unit, lines.attributes["feature"].tolist()) == ("degree", [0, 0, 1, 1, 1])
    assert fl.lines(geopandas.GeoSeries([FLAT])).unit is None
