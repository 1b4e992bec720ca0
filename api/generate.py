#!/usr/bin/python3
"""Makes the Fortran and Python interfaces of libheartbus from its header, and renews listings and tables in a document.

    api/generate.py fortran FILE | python FILE LIBRARY | document FILE

The header keeps to few forms: `#define HEARTBUS_NAME number`, typedefs of structs, functions that begin with HEARTBUS_API.
"""
import re
import sys
from dataclasses import dataclass
from pathlib import Path

API = Path(__file__).resolve().parent

# C: (Python's ctypes, Fortran as argument, Fortran as component of a type or result)
TYPES = {
    "int": ("ctypes.c_int", "integer(c_int), value", "integer(c_int)"),
    "double": ("ctypes.c_double", "real(c_double), value", "real(c_double)"),
    "const char *": ("ctypes.c_char_p", "character(kind=c_char), intent(in) :: {}(*)", "type(c_ptr)"),
    "const double *": ("ctypes.POINTER(ctypes.c_double)", "real(c_double), intent(in) :: {}(*)", "type(c_ptr)"),
    "double *": ("ctypes.POINTER(ctypes.c_double)", "real(c_double), intent(inout)", "type(c_ptr)"),
    "const int *": ("ctypes.POINTER(ctypes.c_int)", "integer(c_int), intent(in) :: {}(*)", "type(c_ptr)"),
    "heartbus_bus *": ("ctypes.c_void_p", "type(c_ptr), value", "type(c_ptr)"),
    "heartbus_bus **": ("ctypes.POINTER(ctypes.c_void_p)", "type(c_ptr), intent(out)", None),
    "heartbus_order *": ("ctypes.POINTER(heartbus_order)", "type(heartbus_order), intent(out)", None),
    "heartbus_partner_points *": ("ctypes.POINTER(heartbus_partner_points)",
                                  "type(heartbus_partner_points), intent(out)", None),
}


@dataclass
class Entry:
    type: str
    name: str
    comment: str = ""


@dataclass
class Function(Entry):
    arguments: tuple = ()


@dataclass
class Struct:
    name: str
    members: list


@dataclass
class Header:
    constants: list
    structs: list
    functions: list


def entry(text, comment=""):
    """'const char *name' as type and name."""
    match = re.fullmatch(r"\s*(.*?)\s*(\**)(\w+)\s*", text, re.S)
    kind = " ".join(match.group(1).split()) + (" " + match.group(2) if match.group(2) else "")
    if kind not in TYPES:
        sys.exit(f"heartbus.h: '{text.strip()}' has a type that Fortran and Python are not told of")
    return Entry(kind, match.group(3), " ".join(comment.split()))


def read():
    text = (API / "heartbus.h").read_text()
    constants = [Entry(value, name, comment.strip()) for name, value, comment in
                 re.findall(r"^#define (HEARTBUS_\w+) (\d+) *(?:/\*(.*?)\*/)?$", text, re.M)]
    structs = [Struct(name, [entry(member, comment) for member, comment in
                             re.findall(r"^\s*([\w *]+);\s*(?:/\*(.*?)\*/)?$", body, re.M)])
               for body, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", text, re.S)]
    functions = []
    comment = ""
    for part in re.finditer(r"/\*(?P<comment>(?:(?!\*/).)*)\*/\n(?=HEARTBUS_API)|HEARTBUS_API (?P<result>[\w ]+[ *])"
                            r"(?P<name>heartbus_\w+)\((?P<arguments>[^)]*)\);", text, re.S):
        if part["comment"]:
            comment = re.sub(r"\s*\n \* ?", " ", part["comment"]).strip()
            continue
        arguments = [] if part["arguments"].strip() == "void" else part["arguments"].split(",")
        functions.append(Function(entry(part["result"] + "x").type, part["name"], comment, tuple(entry(a) for a in arguments)))
    return Header(constants, structs, functions)


def short(name):
    return re.sub("^(HEARTBUS|heartbus)_", "", name)


def python(header, library):
    lines = ['"""The C interface of libheartbus; made from heartbus.h by api/generate.py."""', "import ctypes", "",
             f'LIBRARY = "{library}"  # from the folder of this file', ""]
    lines += [f"{short(c.name)} = {c.type}" + (f"  # {c.comment}" if c.comment else "") for c in header.constants]
    for struct in header.structs:
        lines += ["", "", f"class {struct.name}(ctypes.Structure):", "    _fields_ = ["]
        lines += [f'        ("{m.name}", {TYPES[m.type][0]}),' for m in struct.members]
        lines += ["    ]"]
    lines += ["", "", "FUNCTIONS = {  # name: (result, arguments)"]
    for f in header.functions:
        arguments = ", ".join(TYPES[a.type][0] for a in f.arguments)
        lines += [f'    "{f.name}": ({TYPES[f.type][0]}, [{arguments}]),']
    return "\n".join(lines + ["}", ""])


def declared(argument):
    kind = TYPES[argument.type][1]
    return kind.format(argument.name) if "::" in kind else f"{kind} :: {argument.name}"


def fortran(header):
    lines = ["! The C interface of libheartbus; made from heartbus.h by api/generate.py.", "module heartbus_c",
             "  use, intrinsic :: iso_c_binding", "  implicit none", "  public", ""]
    lines += [f"  integer(c_int), parameter :: {c.name.lower()} = {c.type}" + (f" ! {c.comment}" if c.comment else "")
              for c in header.constants]
    for struct in header.structs:
        lines += ["", f"  type, bind(C) :: {struct.name}"]
        lines += [f"    {TYPES[m.type][2]} :: {m.name}" for m in struct.members] + [f"  end type {struct.name}"]
    lines += ["", "  interface"]
    for f in header.functions:
        names = ", ".join(a.name for a in f.arguments)
        lines += [f"    function c_{f.name}({names}) bind(C, name='{f.name}') result(returned)", "      import"]
        lines += [f"      {declared(a)}" for a in f.arguments]
        lines += [f"      {TYPES[f.type][2]} :: returned", f"    end function c_{f.name}"]
    return "\n".join(lines + ["  end interface", "end module heartbus_c", ""])


def row(*cells):
    return "| " + " | ".join(cells) + " |"


def tags():
    """Of the messages that the library exchanges: the enumeration in common/bus/protocol.h."""
    text = (API.parent / "common/bus/protocol.h").read_text()
    body = re.search(r"enum Tag \{(.*?)\};", text, re.S).group(1)
    return re.findall(r"(tag_\w+),?\s*///< (.*)", body)


def first_sentence(text):
    return re.split(r"(?<=[.]) ", text)[0]


def tables(header):
    version = re.search(r"protocol_version = (\d+)", (API.parent / "common/bus/world.h").read_text()).group(1)
    numbers = {c.name: c for c in header.constants}
    major, minor = (numbers["HEARTBUS_VERSION_" + part].type for part in ("MAJOR", "MINOR"))
    lines = [f"Interface {major}.{minor}, protocol {version}.", "", row("call", "meaning"), row("---", "---")]
    lines += [row(f"`{short(f.name)}({', '.join(a.name for a in f.arguments)})`", first_sentence(f.comment)) for f in header.functions]
    lines += ["", row("constant", "value", "meaning"), row("---", "---", "---")]
    lines += [row(f"`{c.name}`", c.type, c.comment) for c in header.constants if "VERSION" not in c.name]
    lines += ["", row("tag", "number", "from, to, what"), row("---", "---", "---")]
    lines += [row(f"`{name}`", str(k), what) for k, (name, what) in enumerate(tags())]
    return "\n".join(lines + [""])


def renewed(document):
    """A listing is the block after `<!-- listing FILE -->`; tables stand between `<!-- tables -->` and `<!-- end -->`."""
    def listing(match):
        file = API.parent / match.group(2)
        return f"{match.group(1)}\n```{match.group(3)}\n{file.read_text()}```\n"
    document = re.sub(r"(<!-- listing (\S+) -->)\n```(\w*)\n.*?^```\n", listing, document, flags=re.S | re.M)
    return re.sub(r"(<!-- tables -->\n).*?(?=<!-- end -->)", lambda match: match.group(1) + tables(read()), document,
                  flags=re.S)


def main(what, name, *words):
    file = Path(name)
    file.parent.mkdir(parents=True, exist_ok=True)
    if what == "document":
        file.write_text(renewed(file.read_text()))
    else:
        file.write_text(fortran(read()) if what == "fortran" else python(read(), *words))


if __name__ == "__main__":
    main(*sys.argv[1:])
