"""Messages use the words of the field and name the thing that they refuse: messages.py SOURCE_DIR [FILE].

All messages are written to FILE, to be read.
"""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
import list_messages  # noqa: E402

# Words that name no thing of mechanics, or that leave out the noun that they stand for.
ELLIPTIC = re.compile(
    r"\b(?:told|tells?|feels?|felt|stands? (?:for|in|still|twice|more)|gives? way|tears?|torn|off (?:norm )?1|besides|"
    r"makes? of|quick(?:ly)?|likewise|doubtful|what (?:rolls|floats|is there)|in the place of|where there (?:is|are) no(?:ne)?|"
    r"those of what|nobody|leaves? no place|the same is|goes on from there|begins anew|at hand)\b",
    re.IGNORECASE,
)
# The beginning of a sentence of its own.
STAND_IN = re.compile(r"(?:What|Of|Those|Which|So|Told|Its|Likewise|The same|That|As) ")
REFUSALS = {"invalid_argument", "value_error", "type_error", "InputError", "UsageError", "ValueError", "TypeError", "_refused"}
# A value, a quoted word, an option, an argument before a colon or a verb, or a name of the package.
NAMED = re.compile(r"""\{\}|["'`]|--\w|^[\w, ]+: |^(?:the )?\w+ (?:is|has|must|needs|requires)\b|^\w+ and \w+ \w+ (?:is|are)\b|\w[._]\w|^[A-Z]{3,} """)


def faults(messages):
    found = []
    for message in messages:
        if word := ELLIPTIC.search(message.text):
            found.append(f"{message}\n  says '{word[0]}'")
        if STAND_IN.match(message.text) and "What to " not in message.text:
            found.append(f"{message}\n  begins with a word that stands for another")
        if message.use in REFUSALS and not NAMED.search(message.text):
            found.append(f"{message}\n  names nothing that the user gave")
    return found


def check_that_planted_faults_are_found():
    source = """
      void f(double x, const std::string& name) {
        if (x < 0) throw std::invalid_argument("v tears loop \\"" + name + "\\" open");
        if (x > 1) throw std::invalid_argument("the numbers are wrong");
        throw std::invalid_argument("step is " + std::to_string(x) + "; expected 0 or more");
      }
      const char* const help = "Of a state, such as poses";
    """
    planted = list(list_messages.of_cpp("planted.cpp", source))
    assert [(m.use, m.text) for m in planted] == [
        ("invalid_argument", 'v tears loop "{}" open'), ("invalid_argument", "the numbers are wrong"),
        ("invalid_argument", "step is {}; expected 0 or more"), ("text", "Of a state, such as poses")], planted
    python = 'def f(x):\n    """Those of a docstring."""\n    raise ValueError(f"x is {x}; it feels " + "no force")\n'
    planted += list_messages.of_python("planted.py", python)
    assert [fault.split("\n")[1].split()[0] for fault in faults(planted)] == ["says", "names", "begins", "says"], faults(planted)


def main(source, file=None):
    check_that_planted_faults_are_found()
    messages = list_messages.messages(Path(source))
    if file:
        Path(file).write_text("".join(f"{message}\n" for message in messages), encoding="utf-8")
    assert len(messages) > 1000, len(messages)
    found = faults(messages)
    print("\n".join(found) or f"{len(messages)} messages name what they are about")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
