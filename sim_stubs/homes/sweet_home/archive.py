"""Files with a home drawn in Sweet Home 3D, and what they hold besides the plan.

A `.sh3d` file is a zip archive: `Home.xml`, and the models and pictures that it refers to by their
names in the archive. The example homes lie in the same form in the program's own
`sweethome3d.jar`; they are named as if the archive were a folder: `sweethome3d.jar/Studio`.

Source: Sweet Home 3D 7.0, `com.eteks.sweethome3d.io.HomeXMLHandler` and `SweetHome3D.dtd`.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from vizbot.core.errors import ConfigError

_EXAMPLES = "com/eteks/sweethome3d/io/resources/examples/"
_PLAN = "Home.xml"


@dataclass(frozen=True, slots=True, eq=False)
class HomeFile:
    """An open file.

    Attributes:
        plan: The element `home`.
        archive: Holds models and pictures by the names that the plan gives them.
        content: The same as a folder.
    """

    plan: ElementTree.Element
    archive: zipfile.ZipFile
    content: zipfile.Path


def is_home(path: Path) -> bool:
    """Whether the path names a home: a `.sh3d` file, or one in a `.jar`."""
    return path.suffix == ".sh3d" or path.suffix == ".jar" or path.parent.suffix == ".jar"


@contextmanager
def open_home_file(path: Path) -> Iterator[HomeFile]:
    """The home that `path` names, open for reading.

    Raises:
        ConfigError: there is no such home in it, or it cannot be read.
    """
    in_jar = path.parent.suffix == ".jar"
    file = path.parent if in_jar else path
    try:
        with zipfile.ZipFile(file) as archive:
            name = f"{_EXAMPLES}{path.name}.xml" if in_jar else _PLAN
            if name not in archive.namelist():
                raise ConfigError(_missing(path, archive))
            plan = ElementTree.fromstring(archive.read(name))
            yield HomeFile(plan, archive, zipfile.Path(archive))
    except (OSError, EOFError, zipfile.BadZipFile) as error:
        raise ConfigError(f"world {file} is no .sh3d file ({error}); save it again") from error
    except ElementTree.ParseError as error:
        raise ConfigError(f"world {path}: the plan is torn ({error}); save it again") from error


def _missing(path: Path, archive: zipfile.ZipFile) -> str:
    examples = [
        Path(name).stem
        for name in sorted(archive.namelist())
        if name.startswith(_EXAMPLES) and name.endswith(".xml")
    ]
    if examples:
        jar = path if path.suffix == ".jar" else path.parent
        return f"world {path}: take one of {', '.join(f'{jar}/{name}' for name in examples)}"
    return f"world {path} holds no {_PLAN}; save it with Sweet Home 3D 5.3 or newer"
