"""Finding LLVM and refusing what cannot work; no test needs an LLVM of the system."""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gemrender.errors import BackendError
from gemrender.render import llvm

#: As it is, before a test puts another in its place.
system_folders = llvm.system_folders


@pytest.fixture(autouse=True)
def _machine(monkeypatch, tmp_path):
    """A Linux machine on x86-64 that has no LLVM at all; the environment is restored afterwards."""

    def no_wheel(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setenv(llvm.LLVM_VARIABLE, "restored afterwards, whatever the test sets")
    monkeypatch.delenv(llvm.LLVM_VARIABLE)
    monkeypatch.setattr(llvm.platform, "system", lambda: "Linux")
    monkeypatch.setattr(llvm.platform, "machine", lambda: "x86_64")
    monkeypatch.setattr(llvm.importlib.metadata, "files", no_wheel)
    monkeypatch.setattr(llvm, "system_folders", lambda: iter([tmp_path]))
    monkeypatch.setattr(llvm.ctypes.util, "find_library", lambda name: None)


def library(folder: Path, name: str, *links: str) -> Path:
    """Make a fake library in the folder, with links to it in a chain; return the last of them."""
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_bytes(b"")
    for link in links:
        (folder / link).symlink_to(path.name)
        path = folder / link
    return path


def asked(monkeypatch, status=0, out="", err=""):
    """Let every library that is asked for its version, in another process, answer so."""
    monkeypatch.setattr(
        llvm.subprocess, "run", lambda command, **how: subprocess.CompletedProcess(command, status, out, err)
    )


def test_variable_wins_over_the_system(monkeypatch, tmp_path):
    library(tmp_path, "libLLVM.so.23.1")
    named = library(tmp_path / "own", "libLLVM-18.so.1")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(named))
    assert llvm.find_llvm() == llvm.LlvmLibrary(path=named, origin="DRJIT_LIBLLVM_PATH", version=18)


def test_variable_is_final(monkeypatch, tmp_path):
    library(tmp_path, "libLLVM.so.23.1")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(tmp_path / "absent.so"))
    with pytest.raises(
        BackendError, match=r"absent\.so, which is no file; to cure it: unset DRJIT_LIBLLVM_PATH"
    ):
        llvm.find_llvm()


def test_empty_variable_is_as_none(monkeypatch, tmp_path):
    library(tmp_path, "libLLVM.so.23.1")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "")
    assert llvm.find_llvm().origin == "system"


def test_variable_with_a_bare_name_is_looked_up_by_the_loader(monkeypatch):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "libLLVM-no-such-library.so")
    with pytest.raises(BackendError, match="cannot be loaded"):
        llvm.find_llvm()


def test_file_that_is_no_library_is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, "libLLVM.so")))
    with pytest.raises(BackendError, match="cannot be loaded"):
        llvm.find_llvm()


@pytest.mark.parametrize("name", ["libLLVM-14.so.1", "libLLVM-15.0.6.so.1", "libLLVM.so.16.0"])
def test_old_version_is_refused_by_its_name(monkeypatch, tmp_path, name):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, name)))
    with pytest.raises(BackendError, match="of version 17 or newer"):
        llvm.find_llvm()


def test_old_version_is_refused_through_links(monkeypatch, tmp_path):
    link = library(tmp_path, "libLLVM-15.so.1", "libLLVM-15.so", "libLLVM.so")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(link))
    with pytest.raises(BackendError, match=r"libLLVM\.so, which is LLVM 15: below 17"):
        llvm.find_llvm()


def test_library_before_16_cannot_tell_its_version_and_is_refused(monkeypatch, tmp_path):
    asked(monkeypatch, out="0\n")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, "libLLVM.so")))
    with pytest.raises(BackendError, match="an LLVM before 16"):
        llvm.find_llvm()


def test_version_that_cannot_be_told_is_left_to_the_check_after_the_import(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "executable", "")  # as of Python within another program: there is nobody to ask
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, "libLLVM.so")))
    assert llvm.find_llvm().version is None


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-18.so.1", 18),
        ("libLLVM-17.0.6.so.1", 17),
        ("libLLVM.so.23.1", 23),
        ("libLLVM-19.so", 19),
        ("libLLVM-19.dylib", 19),
    ],
)
def test_version_is_read_from_the_name(monkeypatch, tmp_path, name, version):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, name)))
    assert llvm.find_llvm().version == version


@pytest.mark.parametrize(
    ("name", "version"), [("libLLVM-15.so.1", 15), ("libLLVM-14.0.6.so.1", 14), ("libLLVM-3.9.so.1", 3)]
)
def test_an_old_version_is_told_by_its_first_number(monkeypatch, tmp_path, name, version):
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(tmp_path, name)))
    with pytest.raises(BackendError, match=f"which is LLVM {version}: below 17"):
        llvm.find_llvm()


def test_version_is_read_from_the_folder_of_homebrew(monkeypatch, tmp_path):
    folder = tmp_path / "opt" / "homebrew" / "Cellar" / "llvm@20" / "20.1.8" / "lib"
    folder.mkdir(parents=True)
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(library(folder, "libLLVM.dylib")))
    assert llvm.find_llvm().version == 20


def test_library_tells_the_version_of_its_name(monkeypatch, tmp_path):
    """Of the wheel's own library, under its name and under one that tells nothing."""
    monkeypatch.undo()
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    found = llvm.find_llvm()
    if found.origin != "wheel":
        pytest.skip("karellen-llvm-core is not installed")
    nameless = tmp_path / "lib" / "library"
    nameless.parent.mkdir()
    shutil.copy(found.path, nameless)  # a link would tell
    for folder in filter(Path.is_dir, found.path.parent.iterdir()):  # where it looks for what it needs
        (nameless.parent / folder.name).symlink_to(folder)
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(nameless))
    assert llvm.find_llvm().version == found.version


def test_wheel_is_found_and_preferred(monkeypatch, tmp_path):
    monkeypatch.undo()
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    path = library(tmp_path / "lib", "libLLVM.so.22.1", "libLLVM.so")
    info = tmp_path / "site" / "karellen_llvm_core-22.1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: karellen-llvm-core\nVersion: 22.1.0\n")
    (info / "RECORD").write_text("../lib/libLLVM.so,,\n../lib/libLLVM.so.22.1,,\n../lib/libLTO.so,,\n")
    monkeypatch.setattr(sys, "path", [str(info.parent), *sys.path])
    assert llvm.find_llvm() == llvm.LlvmLibrary(path=path.resolve(), origin="wheel", version=22)


def test_highest_version_of_the_system_wins(tmp_path):
    for name in ("libLLVM-9.so.1", "libLLVM-17.so.1", "libLLVM.so.19.1", "libLLVM-15.so.1"):
        library(tmp_path, name)
    found = llvm.find_llvm()
    assert (found.path.name, found.origin) == ("libLLVM.so.19.1", "system")


def test_library_of_rust_is_passed_over(tmp_path):
    library(tmp_path, "libLLVM.so.21.1-rust-1.90.0-stable")
    with pytest.raises(BackendError, match="no LLVM library found"):
        llvm.find_llvm()


def test_only_old_libraries_are_named_with_the_cure(tmp_path):
    library(tmp_path, "libLLVM-15.so.1")
    with pytest.raises(
        BackendError, match=r'libLLVM-15\.so\.1 \(15\), and .* 17 or newer; to cure it: pip install "karellen'
    ):
        llvm.find_llvm()


def test_cure_without_a_wheel_is_the_distribution(monkeypatch):
    monkeypatch.setattr(llvm.platform, "machine", lambda: "aarch64")
    with pytest.raises(BackendError, match="apt-get install libllvm19"):
        llvm.find_llvm()


def test_prepare_names_the_library_to_drjit(tmp_path):
    path = library(tmp_path, "libLLVM.so.19.1")
    llvm.prepare_llvm()
    assert os.environ["DRJIT_LIBLLVM_PATH"] == str(path)


def test_library_that_misses_another_is_told_with_the_package(monkeypatch):
    asked(monkeypatch, 1, err="libz.so.1: cannot open shared object file: No such file or directory\n")
    with pytest.raises(BackendError, match=r"cannot load LLVM .*; to cure it: apt-get install zlib1g$"):
        llvm.require_loadable(llvm.LlvmLibrary(path=Path("libLLVM.so"), origin="wheel", version=23))


@pytest.mark.parametrize(
    ("system", "folder"),
    [
        ("Linux", "usr/lib/x86_64-linux-gnu"),  # Debian
        ("Linux", "usr/lib/llvm-19/lib"),  # apt.llvm.org
        ("Linux", "usr/lib64/llvm19/lib"),  # Fedora, beside its default in lib64
        ("Linux", "usr/lib"),  # Arch
        ("Darwin", "opt/homebrew/Cellar/llvm/19.1.7/lib"),
        ("Darwin", "usr/local/Cellar/llvm@18/18.1.8/lib"),
        ("Darwin", "opt/local/libexec/llvm-19/lib"),  # MacPorts
    ],
)
def test_distributions_folders_are_searched(monkeypatch, tmp_path, system, folder):
    monkeypatch.setattr(llvm.platform, "system", lambda: system)
    (tmp_path / folder).mkdir(parents=True)
    assert tmp_path / folder in system_folders(tmp_path)


@pytest.mark.parametrize(
    ("system", "folder"), [("Linux", "lib"), ("Darwin", "lib"), ("Windows", "Library/bin")]
)
def test_condas_folder_is_searched(monkeypatch, tmp_path, system, folder):
    monkeypatch.setattr(llvm.platform, "system", lambda: system)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    assert tmp_path / folder in system_folders(tmp_path)


# ---- The line for a shell ------------------------------------------------------------------------------


@pytest.fixture
def loadable(monkeypatch):
    """Every library can be loaded."""
    run = subprocess.run

    def loaded(command, **how):
        if command[0] != sys.executable:  # a shell
            return run(command, **how)
        return subprocess.CompletedProcess(command, 0, "23\n", "")

    monkeypatch.setattr(llvm.subprocess, "run", loaded)


def test_the_exported_line_names_the_library(loadable, tmp_path):
    named = library(tmp_path, "libLLVM.so.23.1")
    assert llvm.export_line() == f"export DRJIT_LIBLLVM_PATH={named}"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a shell")
@pytest.mark.parametrize("shell", [shell for shell in ("sh", "bash", "zsh") if shutil.which(shell)])
def test_the_exported_line_is_quoted_for_the_shell(loadable, monkeypatch, tmp_path, shell):
    named = library(tmp_path / 'it\'s $HOME, "is" it\\?', "libLLVM.so.23.1")
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(named))
    script = f'eval "$0"; {sys.executable} -c "import os; print(os.environ[\'DRJIT_LIBLLVM_PATH\'])"'
    done = subprocess.run(
        [shell, "-c", script, llvm.export_line()], capture_output=True, text=True, check=True
    )
    assert done.stdout == f"{named}\n"


def test_no_line_is_exported_for_a_library_that_cannot_be_loaded(monkeypatch, tmp_path):
    library(tmp_path, "libLLVM.so.23.1")
    asked(monkeypatch, 1, err="libz3.so.4: cannot open shared object file: No such file or directory\n")
    with pytest.raises(BackendError, match=r"cannot load LLVM .*; to cure it: install .* libz3\.so\.4$"):
        llvm.export_line()
