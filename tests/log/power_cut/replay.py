"""What a power cut leaves of a folder: the record of record_io.c, played up to some instant.

The model is that of a disk below a journaling file system that promises no more than POSIX does:
- What a sync covers is on the disk. Of later writes to a file, any 512-byte sectors may be there or not, in any order;
  where the file has grown, sectors that are not there are zeros or garbage, or the file is shorter.
- Names (new files, renames, removals) reach the disk in order, but any number of the last ones may be missing until
  their folder is synced. A name may be on the disk before the content of its file.
"""

import random
import struct
from pathlib import Path

SECTOR = 512


class Content:
    """Of one file: what is on the disk for certain, and what was done to it since."""

    def __init__(self, data=b""):
        self.durable = bytearray(data)
        self.now = bytearray(data)
        self.pending = []  # ("w", offset, bytes) or ("t", size)
        self.syncing = 0  # how many of the pending a sync that has begun covers

    def do(self, change):
        self.pending.append(change)
        apply(self.now, change)

    def sync(self):
        for change in self.pending[:self.syncing]:
            apply(self.durable, change)
        del self.pending[:self.syncing]
        self.syncing = 0

    def after_cut(self, rng):
        """One of the contents that the disk may have."""
        data = bytearray(self.durable)
        kind = rng.choice(["none", "all", "first", "sectors", "sectors", "garbage"])
        if kind == "none":
            return bytes(data)
        if kind in ("all", "first"):
            for change in self.pending[:len(self.pending) if kind == "all" else rng.randint(0, len(self.pending))]:
                apply(data, change)
            return bytes(data)
        share = rng.choice([0.1, 0.5, 0.9, 0.99])
        for change in self.pending:
            if change[0] == "t":
                if rng.random() < share:
                    apply(data, change)
                continue
            _, offset, written = change
            at = 0
            while at < len(written):
                end = min(len(written), at + SECTOR - (offset + at) % SECTOR)
                if rng.random() < share:
                    apply(data, ("w", offset + at, written[at:end]))
                elif kind == "garbage" and offset + end > len(data):
                    apply(data, ("w", offset + at, rng.randbytes(end - at)))
                at = end
        return bytes(data)


def apply(data, change):
    if change[0] == "t":
        size = change[1]
        del data[size:]
        data.extend(bytes(size - len(data)))
    else:
        _, offset, written = change
        if len(data) < offset:
            data.extend(bytes(offset - len(data)))
        data[offset:offset + len(written)] = written


def read_trace(path):
    """Yields (operation, file, offset, name, data)."""
    whole = Path(path).read_bytes()
    at = 0
    while at + 33 <= len(whole):
        operation = chr(whole[at])
        file, offset, length, name_length = struct.unpack_from("<4Q", whole, at + 1)
        at += 33
        name = whole[at:at + name_length].decode()
        at += name_length
        data = b""
        if operation in "wr":
            data = whole[at:at + length]
            at += length
        yield operation, file, offset, name, data


class Disk:
    """A folder, and what was done to it."""

    def __init__(self, folder=None):
        self.files = {}  # number -> Content
        self.names = {}  # name -> number, or "folder"
        self.durable_names = {}
        self.pending_names = []
        self.marks = []
        if folder:
            for path in sorted(Path(folder).rglob("*")):
                name = str(path.relative_to(folder))
                if path.is_dir():
                    self.names[name] = "folder"
                elif path.is_file() and not path.is_symlink():
                    number = path.stat().st_ino
                    self.files[number] = Content(path.read_bytes())
                    self.names[name] = (number, self.files[number])
            self.durable_names = dict(self.names)

    def rename(self, changes):
        self.pending_names.append(changes)
        change_names(self.names, changes)

    def do(self, operation, file, offset, name, data):
        if operation == "c":
            if self.names.get(name, (None,))[0] != file:
                self.files[file] = Content()
                self.rename(("add", name, (file, self.files[file])))
        elif operation == "m":
            self.rename(("add", name, "folder"))
        elif operation == "r":
            self.rename(("move", name, data.decode()))
        elif operation == "u":
            self.rename(("remove", name))
        elif operation == "d":
            # Of one folder; the record does not say of which, and no more than all can be on the disk.
            for changes in self.pending_names:
                change_names(self.durable_names, changes)
            self.pending_names.clear()
        elif operation == "n":
            self.marks.append((file, offset))
        elif file in self.files:
            content = self.files[file]
            if operation == "w":
                content.do(("w", offset, data))
            elif operation == "t":
                content.do(("t", offset))
            elif operation == "b":
                content.syncing = len(content.pending)
            elif operation == "s":
                content.sync()

    def write(self, folder, rng):
        """Writes one of the folders that a power cut may leave now. `rng` None: what a kill leaves."""
        names = dict(self.names if rng is None else self.durable_names)
        if rng is not None:
            for changes in self.pending_names[:rng.choice([0, len(self.pending_names), rng.randint(0, len(self.pending_names))])]:
                change_names(names, changes)
        folder.mkdir(parents=True, exist_ok=True)
        for name, file in sorted(names.items()):
            if file == "folder":
                (folder / name).mkdir(parents=True, exist_ok=True)
                continue
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(bytes(file[1].now) if rng is None else file[1].after_cut(rng))


def change_names(names, changes):
    if changes[0] == "add":
        names[changes[1]] = changes[2]
    elif changes[0] == "remove":
        names.pop(changes[1], None)
    elif changes[1] in names:
        names[changes[2]] = names.pop(changes[1])


def cut(trace, until, folder, seed, start=None):
    """Writes into `folder` what is left of `start` after a power cut behind operation `until`; returns the marks."""
    disk = Disk(start)
    for count, step in enumerate(read_trace(trace)):
        if count >= until:
            break
        disk.do(*step)
    disk.write(folder, random.Random(seed))
    return disk.marks
