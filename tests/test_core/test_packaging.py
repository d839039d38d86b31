import subprocess
import sys
import zipfile

from tests.helpers.checkout import ROOT
from vizbot.operator.api.console_routes import FILES


def test_the_wheel_ships_the_five_packages_and_the_page(tmp_path):
    build = "from hatchling.build import build_wheel; import sys; build_wheel(sys.argv[1])"
    subprocess.run([sys.executable, "-c", build, str(tmp_path)], cwd=ROOT, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    top = {name.split("/")[0] for name in names if ".dist-info" not in name}
    assert top == {"vizbot", "drivers", "mapping", "nav", "sim_stubs"}
    assert "vizbot/operator/page/report.html" in names
    assert {f"vizbot/operator/page/{name}" for name, _ in FILES.values()} <= set(names)
