"""Write the golden packages anew.

``PYTHONPATH=robosc_ros1/src python3 robosc_ros1/test/golden/update.py``

Then read what ``git diff`` shows: it is what every user's generated packages will change in.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from emit.golden_packages import PACKAGES, golden_folder, kept_files, package_of  # noqa: E402

packages = {
    (model, target, mode): kept_files(package_of(model, target, mode), target, mode)
    for model, target, mode in PACKAGES
}
for (model, target, mode), files in packages.items():
    folder = golden_folder(model, target, mode)
    shutil.rmtree(folder, ignore_errors=True)
    for path, file in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(file.content, encoding="utf-8")
