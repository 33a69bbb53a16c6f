"""Builds and tests every required configuration, and counts the outcomes: `make test` and `make nightly` run this
program.

Prints the slowest tests and the processor time of each part. The last line reads `N passed, N failed` (and `, N
skipped` if some were). Exits with 1 after any failure, and with --complete also after too few tests.
"""

import argparse
import fnmatch
import os
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

SOURCE = Path(__file__).resolve().parents[1]
PYTHON = SOURCE / "build/venv/bin/python"
READY = SOURCE / "build/venv/tests"  # once all that the tests need is installed


class Stage(NamedTuple):
    """A preset to build and to test."""

    preset: str
    libraries: str = ""  # the preset that builds the libraries for it, if it does not build them itself
    programs: str = "*"  # which cases of every program, a filter of GoogleTest
    others: str = ""  # which tests that are no programs of GoogleTest, by the first word of their names
    environment: dict = {}
    emulator: tuple = ()  # the command under which programs run


ASAN = Stage("asan")
TESTS = Stage("tests", libraries="release", others="Examples")
RELEASE = Stage("release", programs="", others="Guards|Package|Viewer")
NIGHTLY = {
    "aarch64": Stage("aarch64", programs="*-InstructionSets.*",  # which start the program itself, without the emulator
                     emulator=("qemu-aarch64",)),
    "clang": Stage("clang", others="Examples|Guards|Page"),
    "descriptions": Stage("asan", programs="HostileDescriptions.*:RoundTrip.*Random*",
                          environment={"AXODE_RANDOM_TREES": "5000"}),
    "asan-all": Stage("asan-all", others="Examples", environment={"AXODE_RANDOM_TREES": "30"}),
    "tsan": Stage("tsan", programs="*Threads*:*ManyStates*",
                  environment={"AXODE_RANDOM_TREES": "3",  # it makes calls a hundred times as long
                               "TSAN_OPTIONS": "suppressions=tests/support/thread_sanitizer.txt"}),
    "trees": Stage("tests", libraries="release",
                   programs="*ForwardDynamics.Undoes*:*ClosedForms.AgreeWith*:*FastPath*:*/Invariance.*",
                   environment={"AXODE_RANDOM_TREES": "100000"}),
    "laws": Stage("tests", libraries="release",
                  programs="*/InverseDynamics.AgreesWith*:*FloatInverseDynamics.AgreesWith*:*/Poses.AreProducts*:"
                           "*/EquationsOfMotion.MassMatrixIs*:*/EquationsOfMotion.AreTheSum*:*/EquationsOfMotion.GravityIs*:"
                           "ClosedForms.*:*/MomentumForm.*",
                  environment={"AXODE_RANDOM_TREES": "4000"}),
}
FUZZ_SECONDS = 600
#: Processors of qemu-user without newer instructions, and the set that axode must choose on them.
PROCESSORS = {"qemu64": "x86-64", "Haswell": "x86-64-v3"}
LAWS = "build/tests/tests/test_laws"
#: Laws that take a minute under qemu-user.
EMULATED_LAWS = "*EveryFunction*:*ForwardDynamics.Undoes*"
# Numbers of a complete run; far from these a part of the tests is missing.
LEAST_PASSED, MOST_SKIPPED = 7000, 200
SLOWEST = 30
NIGHTLY_BRIDGES = {"distributed",  # which starts clusters and kills their workers
                   "robots", "torch"}  # which install 1 GB, and several


def run(*command, environment=None):
    print("+", *command, flush=True)
    return subprocess.run(command, cwd=SOURCE, env={**os.environ, **(environment or {})}).returncode == 0


def run_quietly(*command):
    """Runs a command that has too many arguments to be printed."""
    print("+", *command[:3], "...", flush=True)
    return subprocess.run(command, cwd=SOURCE).returncode == 0


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Costs:
    """The CPU seconds of each configuration and part."""

    def __init__(self):
        self.rows = []

    def measure(self, configuration, part, call, split=lambda: {}):
        """The result of a call; `split` says which parts it took how long for, in any unit."""
        start = processor_seconds()
        result = call()
        spent = processor_seconds() - start
        shares = split() or {part: 1}
        for name, share in shares.items():
            self.rows.append((configuration, name, spent * share / sum(shares.values())))
        return result

    def print(self):
        print("\nCPU seconds, by part")
        for configuration in dict.fromkeys(row[0] for row in self.rows):
            rows = [row[1:] for row in self.rows if row[0] == configuration]
            print(f"  {configuration:32} {sum(seconds for _, seconds in rows):6.0f}")
            for name, seconds in rows:
                print(f"    {name:30} {seconds:6.0f}")
        print(f"  {'all':32} {sum(row[2] for row in self.rows):6.0f}\n", flush=True)


def part_of(output):
    """The part of the tree to which a file of a build belongs."""
    steps = Path(output).parts
    if steps[0] == "tests" and len(steps) > 1:
        return "build tests/" + (steps[2] if steps[1] == "CMakeFiles" else steps[1]).removeprefix("test_").split(".")[0]
    if steps[0] in ("apps", "examples", "bench"):
        return f"build {steps[0]}"
    return "build axode" if steps[0] in ("CMakeFiles", "lib") else "build apps"


def compiled(log):
    """The entries of a log of ninja: one line for each file that was built."""
    return set(log.read_text().splitlines()[1:]) if log.exists() else set()


def time_by_part(lines):
    """The seconds that building each part of the tree took."""
    parts = Counter()
    for start, end, *_, output, _ in (line.split("\t") for line in lines):
        if not Path(output).is_absolute():
            parts[part_of(output)] += (int(end) - int(start)) / 1000
    return dict(sorted(parts.items()))


def build(preset, jobs, costs, target=()):
    log = SOURCE / "build" / preset / ".ninja_log"
    before = compiled(log)
    return costs.measure(preset, "configure", lambda: run("cmake", "--preset", preset)) and costs.measure(
        preset, "build", lambda: run("cmake", "--build", "--preset", preset, "--parallel", str(jobs), *target),
        split=lambda: time_by_part(compiled(log) - before))


seconds = {}  # of each test, by the folder of its results and its name


def note_seconds(file, case, name):
    time_taken = case.get("time") or "0"  # with a decimal comma if the test has set a locale
    seconds[str(file.parent.relative_to(SOURCE / "build")), name] = float(time_taken.replace(",", "."))


def print_slowest():
    print(f"\nSeconds, of the {SLOWEST} slowest tests")
    for (folder, name), time_taken in sorted(seconds.items(), key=lambda entry: -entry[1])[:SLOWEST]:
        print(f"  {time_taken:6.1f}  {folder}: {name}")


def outcomes_of_ctest(junit):
    """Name -> passed, failed or skipped. A test that ctest could not run counts as skipped only if the test itself
    said so."""
    found = {}
    for case in ElementTree.parse(junit).getroot().iter("testcase"):
        reason = case.find("skipped")
        note_seconds(junit, case, case.get("name"))
        if case.get("status") == "run":
            found[case.get("name")] = "passed"
        elif case.get("status") == "disabled" or reason is not None and reason.get("message", "").startswith("SKIP_"):
            found[case.get("name")] = "skipped"
        else:
            found[case.get("name")] = "failed"
    return found


def outcomes_of_program(xml):
    """Name -> passed, failed or skipped, for a program of GoogleTest or for pytest."""
    found = {}
    for case in ElementTree.parse(xml).getroot().iter("testcase") if xml.exists() else []:
        if case.get("status", "run") == "run":
            wrong = case.find("failure") is not None or case.find("error") is not None
            name = f"{case.get('classname')}.{case.get('name')}"
            note_seconds(xml, case, name)
            found[name] = "failed" if wrong else "skipped" if case.find("skipped") is not None else "passed"
    return found


def run_ctest(stage, jobs, folder):
    junit = folder / "tests.xml"
    junit.unlink(missing_ok=True)
    passed = run("ctest", "--preset", stage.preset, "--parallel", str(jobs), "--no-tests=error", "--output-junit",
                 str(junit), "--tests-regex", rf"^({stage.others})\.", environment=stage.environment)
    results = outcomes_of_ctest(junit) if junit.exists() else {}
    if not passed and "failed" not in results.values():
        results["ctest"] = "failed"
    return results


def run_shard(program, shard, shards, stage):
    """Outcomes of a part of a program, which reports failures alone."""
    xml = program.with_name(f"{program.name}_{shard}.xml")
    xml.unlink(missing_ok=True)
    done = subprocess.run(
        [*stage.emulator, program, f"--gtest_filter={stage.programs}", f"--gtest_output=xml:{xml}", "--gtest_brief=1"], cwd=SOURCE,
        env={**os.environ, **stage.environment, "GTEST_TOTAL_SHARDS": str(shards), "GTEST_SHARD_INDEX": str(shard)},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    results = outcomes_of_program(xml)
    if done.returncode and "failed" not in results.values():
        results[f"{program.name}, shard {shard}"] = "failed"
    if "failed" in results.values():
        print(done.stdout[-20000:], flush=True)
    return results


def names_in(program, emulator):
    """The full names of the tests of a program of GoogleTest."""
    suite = ""
    for line in subprocess.run([*emulator, program, "--gtest_list_tests"], capture_output=True, text=True).stdout.splitlines():
        if line.startswith(" "):
            yield suite + line.strip()
        else:
            suite = line


def renamed(tests, programs, emulator=()):
    """The patterns in a filter of tests, as failures, that select no test of the programs: it has another name now."""
    names = [name for program in programs for name in names_in(program, emulator)]
    return {f"no test is named {pattern}": "failed" for pattern in tests.replace("-", ":").split(":")
            if not fnmatch.filter(names, pattern)}


def run_programs(stage, jobs, folder):
    programs = sorted(path for path in (folder / "tests").glob("test_*") if path.is_file() and os.access(path, os.X_OK))
    print("+", *(program.name for program in programs), f"--gtest_filter={stage.programs}", flush=True)
    results = {}
    with ThreadPoolExecutor(jobs) as pool:
        for found in pool.map(lambda part: run_shard(*part, jobs, stage),
                              [(program, shard) for program in programs for shard in range(jobs)]):
            results.update(found)
    return results | renamed(stage.programs, programs, stage.emulator) if results else {"programs": "failed"}


def test(name, stage, jobs, costs):
    """Outcomes of one stage; a stage that does not build, or finds no test, is one failure."""
    if not all(build(preset, jobs, costs) for preset in (stage.libraries, stage.preset) if preset):
        return {"build": "failed"}
    folder = SOURCE / "build" / stage.preset
    results = {}
    if stage.programs:
        results |= costs.measure(name, "run programs", lambda: run_programs(stage, jobs, folder))
    if stage.others:
        results |= costs.measure(name, "run others", lambda: run_ctest(stage, jobs, folder))
    return results


def test_at_low_priority(name, stage, jobs, log):
    """The outcomes, costs and times of a stage, whose output goes to a file, in a process of its own."""
    os.nice(19)
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(output, stream)
    costs = Costs()
    return test(name, stage, jobs, costs), costs.rows, seconds


def start_at_low_priority(name, stage, jobs, costs):
    """Starts a stage that takes the processors when other stages leave one without work, as they do when they link or
    draw pages. The result is a function that waits for the outcomes and prints what the stage said."""
    log = SOURCE / "build" / f"{name}.log"
    log.parent.mkdir(exist_ok=True)
    print(f"+ {name}, at low priority: {log}\n", flush=True)
    pool = ProcessPoolExecutor(1)
    future = pool.submit(test_at_low_priority, name, stage, jobs, log)

    def wait():
        outcomes, rows, times = future.result()
        print(log.read_text(errors="replace"), flush=True)
        costs.rows += rows
        seconds.update(times)
        return outcomes

    return wait


def run_pytest(python, tests, jobs, folder):
    xml = folder / "tests.xml"
    xml.unlink(missing_ok=True)
    passed = run(str(python), "-m", "pytest", "-q", "-rs", "-p", "no:cacheprovider", "--numprocesses", str(jobs), "--dist",
                 "worksteal", "--junit-xml", str(xml), tests)
    results = outcomes_of_program(xml)
    if not passed and "failed" not in results.values():
        results["pytest"] = "failed"
    return results


def check_style(jobs, costs):
    """Outcomes of the checks of style that take seconds; mypy and tsc are tests of the package and of the viewer."""
    sources = [str(path.relative_to(SOURCE)) for folder in ("axode", "apps", "bench", "examples", "python", "tests")
               for pattern in ("*.hpp", "*.cpp") for path in sorted((SOURCE / folder).rglob(pattern))]
    checks = {"clang-format": lambda: run_quietly("clang-format-14", "--dry-run", "-Werror", *sources)}
    if READY.exists():
        checks["ruff"] = lambda: run(str(PYTHON), "-m", "ruff", "check", "--quiet", ".")
    return {name: "passed" if costs.measure("style", name, check) else "failed" for name, check in checks.items()}


def make_environments(bridges):
    """Starts to make the Python environments of the tests and of bridges. The result is a function that waits for
    them and prints what went wrong."""
    wanted = ["build/venv/tests", *(f"build/bridges/{bridge}/ready" for bridge in sorted(bridges))]
    print("+ make", *wanted, "&\n", flush=True)
    log = tempfile.TemporaryFile("w+")
    make = subprocess.Popen(["make", "--no-print-directory", "--keep-going", *wanted], cwd=SOURCE, stdout=log,
                            stderr=subprocess.STDOUT)

    def wait():
        if make.wait() != 0:
            log.seek(0)
            print(log.read(), "The tests that need an environment which is not there will be skipped.", flush=True)
        return {}

    return wait


def test_python(jobs, costs):
    """Outcomes of the Python package's tests; skipped if there is no environment for them."""
    if not READY.exists():
        return {"package": "skipped"}
    if not costs.measure("python", "build", lambda: run("make", "python")):
        return {"package": "failed"}
    return costs.measure("python", "run", lambda: run_pytest(PYTHON, "tests/python", jobs, SOURCE / "build/python"))


def test_bridge(name, jobs, costs):
    """Outcomes of the tests of one bridge; skipped if the other package cannot be installed."""
    folder = SOURCE / "build/bridges" / name
    if not READY.exists() or not costs.measure(f"bridge {name}", "install", lambda: run(
            "make", "--no-print-directory", f"build/bridges/{name}/ready")):
        return {"environment": "skipped"}
    return costs.measure(f"bridge {name}", "run", lambda: run_pytest(folder / "bin/python", f"tests/bridges/{name}", jobs, folder))


def fuzz(jobs, costs):
    """One outcome for each reader of files: passed if no input that was found in ten minutes makes it fail."""
    if not build("fuzz", jobs, costs):
        return {"build": "failed"}
    folder = SOURCE / "build/fuzz/tests/fuzz"

    def search(reader):
        found = folder / f"found_{reader}"
        found.mkdir(exist_ok=True)
        return "passed" if run(str(folder / reader), str(found), f"tests/fuzz/corpus/{reader}", "-timeout=10",
                               f"-max_total_time={FUZZ_SECONDS}", "-verbosity=0", "-print_final_stats=1",
                               f"-artifact_prefix={folder}/") else "failed"

    readers = [path.stem for path in sorted((SOURCE / "tests/fuzz").glob("*.cpp"))]
    with ThreadPoolExecutor(jobs) as pool:
        return costs.measure("fuzz", "run", lambda: dict(zip(readers, pool.map(search, readers))))


def build_site(jobs, costs):
    """The site of the documentation is built without a warning, and all its links lead somewhere."""
    if not costs.measure("docs", "run", lambda: run("make", "docs", f"JOBS={jobs}")):
        return {"docs": "failed"}
    return {"docs": "passed"}


def lint(jobs, costs):
    """clang-tidy finds nothing in the library and the command."""
    return {"lint": "passed" if costs.measure("lint", "run", lambda: run("make", "lint", f"JOBS={jobs}")) else "failed"}


def check_tests(jobs, costs):
    """The tests of the ledger run the code that they name, and every mistake of tests/mutants.tsv makes a test fail."""
    if not build("coverage", jobs, costs):
        return {"build": "failed"}
    return {tool: "passed" if costs.measure("coverage", tool, lambda tool=tool: run(
        sys.executable, f"tools/{tool}.py", "--jobs", str(jobs))) else "failed" for tool in ("ledger_coverage", "mutants")}


def emulate(jobs, costs):
    """Outcomes on emulated processors: every function answers on x86-64 ones that lack newer instructions."""
    outcomes = {}

    def laws(emulator):
        return run(*emulator, LAWS, f"--gtest_filter={EMULATED_LAWS}", "--gtest_brief=1",
                   environment={"AXODE_RANDOM_TREES": "1"})

    def chooses(emulator, instructions):
        version = subprocess.run([*emulator, "build/release/axode", "--version"], cwd=SOURCE, capture_output=True, text=True)
        return instructions in version.stdout.split()

    if build("release", jobs, costs) and build("tests", jobs, costs, ["--target", "test_laws"]):
        for processor, instructions in PROCESSORS.items():
            emulator = ["qemu-x86_64", "-cpu", processor]
            outcomes[processor] = costs.measure("emulated", processor, lambda: chooses(emulator, instructions) and laws(
                emulator) and not renamed(EMULATED_LAWS, [LAWS]))
    return {name: "passed" if outcomes.get(name) else "failed" for name in PROCESSORS}


def validate(costs):
    """Published motions, and motions in closed form, are computed within their bounds."""
    passed = costs.measure("validation", "build", lambda: run("make", "python")) and all(
        costs.measure("validation", "run", lambda: run(str(PYTHON), f"tools/{tool}.py"))
        for tool in ("validation", "contact_tables"))
    return {"validation": "passed" if passed else "failed"}


def walk_pages(costs):
    """A browser moves the sliders on the pages of all mechanisms, of which `make test` takes a part."""
    tests = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python/test_pages_of_mechanisms.py"]
    passed = costs.measure("pages", "build", lambda: run("make", "python")) and costs.measure(
        "pages", "run", lambda: run(str(PYTHON), *tests, environment={"AXODE_EVERY_PAGE": "1"}))
    return {"pages": "passed" if passed else "failed"}


def measure_speed(jobs, costs):
    """The benchmarks run to their end."""
    if not costs.measure("bench", "run", lambda: run("make", "bench", f"JOBS={jobs}")):
        return {"bench": "failed"}
    return {"bench": "passed"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--nightly", action="store_true", help="run what `make nightly` adds instead")
    parser.add_argument("--complete", action="store_true",
                        help="fail unless nearly all tests ran: continuous integration has whatever they need")
    parser.add_argument("--bridges", action="store_true", help="run the tests of all bridges alone")
    arguments = parser.parse_args()

    jobs, costs = arguments.jobs, Costs()
    bridges = {file.parent.name for file in SOURCE.glob("tests/bridges/*/requirements.txt")}
    runs, wait_for_asan = {}, None
    if arguments.nightly:
        bridges &= NIGHTLY_BRIDGES
        for name, stage in NIGHTLY.items():
            runs[name] = lambda name=name, stage=stage: test(name, stage, jobs, costs)
        runs["fuzz"] = lambda: fuzz(jobs, costs)
        runs["docs"] = lambda: build_site(jobs, costs)
        runs["lint"] = lambda: lint(jobs, costs)
        runs["coverage"] = lambda: check_tests(jobs, costs)
        runs["emulated"] = lambda: emulate(jobs, costs)
        runs["validation"] = lambda: validate(costs)
        runs["pages"] = lambda: walk_pages(costs)
        runs["bench"] = lambda: measure_speed(jobs, costs)
    elif not arguments.bridges:
        bridges -= NIGHTLY_BRIDGES
        wait_for_asan = start_at_low_priority("asan", ASAN, jobs, costs)
        wait_for_environments = make_environments(bridges)
        runs["release"] = lambda: test("release", RELEASE, jobs, costs)
        runs["environments"] = lambda: costs.measure("environments", "install", wait_for_environments)
        runs["tests"] = lambda: test("tests", TESTS, jobs, costs)
        runs["style"] = lambda: check_style(jobs, costs)
        runs["python"] = lambda: test_python(jobs, costs)  # with the libraries of release
    for name in sorted(bridges):
        runs[f"bridge {name}"] = lambda name=name: test_bridge(name, jobs, costs)
    if wait_for_asan:
        runs["asan"] = wait_for_asan

    results = {}
    for name, test_all in runs.items():
        start = time.monotonic()
        results.update({(name, case): outcome for case, outcome in test_all().items()})
        print(f"{name}: {time.monotonic() - start:.0f} s\n", flush=True)

    for outcome in ("skipped", "failed"):
        for (configuration, case), found in results.items():
            if found == outcome:
                print(f"{outcome}: {configuration}: {case}")
    print_slowest()
    costs.print()
    count = Counter(results.values())
    complete = not arguments.complete or count["passed"] >= LEAST_PASSED and count["skipped"] <= MOST_SKIPPED
    if not complete:
        print(f"Too few tests: at least {LEAST_PASSED} must pass, and at most {MOST_SKIPPED} may be skipped.")
    skipped = f", {count['skipped']} skipped" if count["skipped"] else ""
    print(f"{count['passed']} passed, {count['failed']} failed{skipped}")
    return 1 if count["failed"] or not count["passed"] or not complete else 0


if __name__ == "__main__":
    sys.exit(main())
