"""Reads the journals of a sweep (runtime/results/journal/README.md) without cdb."""
import contextlib
import pathlib
import sqlite3
import struct
import zlib


@contextlib.contextmanager
def opened(path):
    """A connection that may write, because one that may not would leave files beside a journal."""
    with contextlib.closing(sqlite3.connect(path, timeout=60)) as journal:
        yield journal


def journals(folder):
    return sorted(pathlib.Path(folder).glob("*.journal"))


def query(folder, sql):
    """The rows of all journals of a folder; a journal that is being created has none."""
    rows = []
    for path in journals(folder):
        try:
            with opened(path) as journal:
                rows += journal.execute(sql).fetchall()
        except sqlite3.OperationalError as error:
            if "no such table" not in str(error):
                raise
    return rows


def runs(folder):
    """When each finished run was written, in ns since 1970, by its id."""
    return dict(sorted(query(folder, "SELECT id, written FROM run ORDER BY written")))


def request(folder, what):
    """The newest value of what was asked of the sweep; empty if nothing was."""
    rows = query(folder, "SELECT written, value FROM asked WHERE what = '%s'" % what)
    return max(rows)[1] if rows else ""


class _Bytes:
    def __init__(self, stored):
        self.bytes, self.at = zlib.decompress(stored[8:]), 0

    def number(self, form):
        (value,) = struct.unpack_from(form, self.bytes, self.at)
        self.at += struct.calcsize(form)
        return value

    def text(self):
        size = self.number("<Q")
        self.at += size
        return self.bytes[self.at - size:self.at].decode()

    def list(self, item):
        return [item() for _ in range(self.number("<Q"))]

    def array(self):
        return self.text(), self.number("<b"), self.list(lambda: self.number("<Q")), self.list(lambda: self.number("<Q"))


def numbers(folder):
    """The numbers of each finished run by their names, by its id; of a run that is there twice, the newest."""
    found = {}
    for run, about, facts, _ in sorted(
            query(folder, "SELECT id, bytes, facts, written FROM run JOIN about ON about = about.number"), key=lambda row: row[3]):
        names, values = _Bytes(about), _Bytes(facts)
        names.list(names.array)
        found[run] = dict(zip(names.list(names.text), values.list(lambda: values.number("<d"))))
    return found
