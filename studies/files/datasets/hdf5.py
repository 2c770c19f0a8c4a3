"""What an HDF5 file of others may hold: numbers and texts of one group, and nothing that leads out of the file."""

from __future__ import annotations

import math

import h5py
from h5py import h5a, h5d, h5t, h5z

# what `save_netcdf` compresses with, and what checks it
_FILTERS = {h5z.FILTER_DEFLATE, h5z.FILTER_SHUFFLE, h5z.FILTER_FLETCHER32}
_LAYOUTS = {h5d.COMPACT, h5d.CONTIGUOUS, h5d.CHUNKED}
_NUMBERS = {h5t.INTEGER, h5t.FLOAT}
# bytes of the largest number that NumPy knows on every machine
_LARGEST_NUMBER = 8
# how NetCDF says which dimension belongs to which variable: references within the file
_REFERENCES = {b"DIMENSION_LIST": h5t.VLEN, b"REFERENCE_LIST": h5t.COMPOUND}


def refuse_foreign(file: h5py.File, largest: int) -> None:
    """ValueError for all that no result of ours has, before any number of it is read.

    Links, groups, external storage, virtual layouts, other filters and types, and more than `largest` bytes in all.
    """
    size = _attributes(file)
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink) or file.get(name, getclass=True) != h5py.Dataset:
            raise ValueError(f"{name} is a link or a group")
        size += _dataset(name, file[name]) + _attributes(file[name])
        if size > largest:
            raise ValueError(f"it holds more than {largest:,} bytes")


def _dataset(name: str, dataset: h5py.Dataset) -> int:
    """The bytes of a plain dataset that is whole in the file."""
    plist, kind = dataset.id.get_create_plist(), dataset.id.get_type()
    if plist.get_external_count() or plist.get_layout() not in _LAYOUTS:
        raise ValueError(f"the numbers of {name} are in another file or place")
    if not {plist.get_filter(i)[0] for i in range(plist.get_nfilters())} <= _FILTERS:
        raise ValueError(f"{name} is compressed in another way")
    text = kind.get_class() == h5t.STRING and not kind.is_variable_str()
    if dataset.shape is None or not (text or _is_number(kind)):
        raise ValueError(f"{name} has neither numbers nor texts")
    count: int = max(math.prod(dataset.shape), math.prod(dataset.chunks or ()))
    return int(kind.get_size()) * count


def _attributes(owner: h5py.File | h5py.Dataset) -> int:
    """The bytes of attributes that are numbers, texts or the references of NetCDF."""
    size = 0
    for place in range(h5a.get_num_attrs(owner.id)):
        attribute = h5a.open(owner.id, index=place)
        kind = attribute.get_type()
        if kind.get_class() != h5t.STRING and not _is_number(kind) and not _is_reference(attribute.name, kind):
            raise ValueError(f"an attribute of {owner.name} is neither numbers nor text")
        size += int(kind.get_size()) * attribute.get_space().get_simple_extent_npoints()
    return size


def _is_number(kind: h5t.TypeID) -> bool:
    return kind.get_class() in _NUMBERS and kind.get_size() <= _LARGEST_NUMBER


def _is_reference(name: bytes, kind: h5t.TypeID) -> bool:
    if kind.get_class() != _REFERENCES.get(name):
        return False
    member = kind.get_super() if name == b"DIMENSION_LIST" else kind.get_member_type(0)
    return bool(member.equal(h5t.STD_REF_OBJ))
