"""A transcription's functions as C: every instruction on as many stages as a register holds.

The code is a library that CasADi loads (`ca.external`); `llsrbm.ocp` says why. A file holds one
family's stage functions, so that a compiler never has all of them in memory; another one gathers
the stages' variables, calls them and puts the results where they belong.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import casadi as ca

from llsrbm.errors import Error
from llsrbm.ocp.stage_functions import StageFunctions
from llsrbm.ocp.transcription import Block, Structure, Transcription

# Instructions a C function: compilers take more than linear time for the length of one.
PIECE = 400

_BINARY = {
    ca.OP_ADD: "{0}+{1}",
    ca.OP_SUB: "{0}-{1}",
    ca.OP_MUL: "{0}*{1}",
    ca.OP_DIV: "{0}/{1}",
    ca.OP_ATAN2: "ATAN2({0},{1})",
}
_UNARY = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0}*{0}",
    ca.OP_TWICE: "2.0*{0}",
    ca.OP_INV: "1.0/{0}",
    ca.OP_SQRT: "SQRT({0})",
    ca.OP_SIN: "SIN({0})",
    ca.OP_COS: "COS({0})",
}

_TYPES = """\
#include <math.h>
#if defined(__AVX512F__)
#define LANES 8
#elif defined(__AVX__)
#define LANES 4
#else
#define LANES 2
#endif
typedef double lanes __attribute__((vector_size(8 * LANES)));
"""

# Of a family with one stage, and of one with many.
_ONE = """\
#define WIDTH 1
typedef double real;
#define SQRT sqrt
#define SIN sin
#define COS cos
#define ATAN2 atan2
"""
_MANY = """\
#define WIDTH LANES
typedef lanes real;
#define EACH(name, function) static inline real name(real a) \\
  { real r; for (int i = 0; i < LANES; i++) r[i] = function(a[i]); return r; }
EACH(SQRT, sqrt)
EACH(SIN, sin)
EACH(COS, cos)
static inline real ATAN2(real a, real b)
  { real r; for (int i = 0; i < LANES; i++) r[i] = atan2(a[i], b[i]); return r; }
"""

# Evaluates one kind of a family's functions for all its stages. Of the last ones fewer than WIDTH
# may be left: the rest of the lanes repeat the last stage and are not stored.
_LOOP = """\
void {name}(const double *x, const double *p, double lam_f, const double *lam, double *const *to,
            double *w) {{
  real *z = (real *)w, *shared = z + {width}, *local = shared + {shared}, *l = local + {local};
  real *out = l + {height}, *work = out + {outputs};
  for (int i = 0; i < {shared}; i++) shared[i] = (real){{0}} + p[i];
  real f = (real){{0}} + lam_f;
  for (int first = 0; first < {count}; first += WIDTH) {{
    for (int lane = 0; lane < WIDTH; lane++) {{
      int k = first + lane < {count} ? first + lane : {count} - 1;
      for (int i = 0; i < {width}; i++) LANE(z[i]) = x[variable_at[k] + i];
      for (int i = 0; i < {local}; i++) LANE(local[i]) = p[local_at[k * {local} + i]];
      {multipliers}
    }}
    {calls}
    for (int lane = 0; lane < WIDTH && first + lane < {count}; lane++) {{
      int k = first + lane;
{stores}
    }}
  }}
}}
"""


class NotInC(Error):
    """An expression has an operation that is not written as C here."""


@dataclass(frozen=True)
class _Kind:
    """One of `StageFunctions`: where its outputs go.

    Attributes:
        name: the attribute.
        multipliers: whether lam_f and lam are among its arguments.
        outputs: of each one, the table of the places of the stages' first elements.
    """

    name: str
    multipliers: bool
    outputs: tuple[str, ...]


_KINDS = (
    _Kind("cost", False, ("cost_at",)),
    _Kind("gradient", False, ("variable_at",)),
    _Kind("constraints", False, ("row_at",)),
    _Kind("jacobian", False, ("row_at", "jacobian_at")),
    _Kind("hessian", True, ("hessian_at",)),
)


def c_files(transcription: Transcription) -> dict[str, str]:
    """Name -> content of the C files of a library with a transcription's functions.

    Raises:
        NotInC: it has an operation that cannot be written.
    """
    families = _families(transcription.blocks)
    files = {f"family{i}.c": _family(f"family{i}", f) for i, f in enumerate(families)}
    files["problem.c"] = _problem(transcription, families)
    return files


@dataclass
class _Family:
    """Stage functions, and the places of all stages that share them."""

    functions: StageFunctions
    shared: int
    variables: list[int]
    rows: list[int]
    jacobian: list[int]
    hessian: list[int]
    local: list[list[int]]

    @property
    def count(self) -> int:
        return len(self.variables)


def _families(blocks: Sequence[Block]) -> list[_Family]:
    found: dict[int, _Family] = {}
    jacobian = hessian = 0
    for block in blocks:
        f = block.functions
        shared = int(f.constraints.numel_in(1))
        family = found.setdefault(id(f), _Family(f, shared, [], [], [], [], []))
        for k in range(block.count):
            family.variables.append(block.first_variable + k * block.width)
            family.rows.append(block.first_row + k * block.height)
            family.jacobian.append(jacobian)
            family.hessian.append(hessian)
            places = (*block.local, *block.own[k : k + 1])
            family.local.append([i for at in places for i in range(at.start, at.stop)])
            jacobian += f.jacobian_pattern.nnz()
            hessian += f.hessian_pattern.nnz()
    return list(found.values())


def _family(name: str, family: _Family) -> str:
    """The file of one family."""
    one = family.count == 1
    parts = [_TYPES, _ONE if one else _MANY]
    parts.append(f"#define LANE(a) {'(a)' if one else '(a)[lane]'}\n")
    tables = {
        "variable_at": family.variables,
        "row_at": family.rows,
        "jacobian_at": family.jacobian,
        "hessian_at": family.hessian,
        "local_at": [i for places in family.local for i in places],
        "cost_at": [0] * family.count,
    }
    parts += [_table(f"static const int {key}", values) for key, values in tables.items()]
    for kind in _KINDS:
        function = getattr(family.functions, kind.name)
        pieces, slots = _pieces(f"{name}_{kind.name}", function)
        parts += pieces
        parts.append(_loop(name, kind, function, family, len(pieces)))
        scalars = sum(function.numel_in(i) for i in range(function.n_in()))
        outputs = sum(function.numel_out(i) for i in range(function.n_out()))
        # One more for the alignment of the first.
        size = scalars + family.functions.height + outputs + slots + 1
        parts.append(f"int {name}_{kind.name}_size(void) {{ return {size} * WIDTH; }}\n")
    return "\n".join(parts)


def _loop(name: str, kind: _Kind, function: ca.Function, family: _Family, pieces: int) -> str:
    height = family.functions.height
    stores, at = [], 0
    for j, table in enumerate(kind.outputs):
        size = function.numel_out(j)
        # The cost is the sum over all stages.
        put = "+=" if kind.name == "cost" else "="
        stores.append(
            f"      if (to[{j}]) for (int i = 0; i < {size}; i++) "
            f"to[{j}][{table}[k] + i] {put} LANE(out[{at} + i]);"
        )
        at += size
    gather = f"for (int i = 0; i < {height}; i++) LANE(l[i]) = lam[row_at[k] + i];"
    arguments = "z, shared, local, f, l, out, work"
    return _LOOP.format(
        name=f"{name}_{kind.name}",
        width=family.functions.width,
        shared=family.shared,
        local=int(function.numel_in(2)),
        height=height if kind.multipliers else 0,
        outputs=at,
        count=family.count,
        multipliers=gather if kind.multipliers else "",
        calls="\n    ".join(f"{name}_{kind.name}_{i}({arguments});" for i in range(pieces)),
        stores="\n".join(stores),
    )


def _pieces(name: str, function: ca.Function) -> tuple[list[str], int]:
    """C functions that are to be called one after the other, and how many values cross them."""
    lines = list(_Reader(function).lines())
    pieces = [lines[i : i + PIECE] for i in range(0, max(len(lines), 1), PIECE)]
    made = {line.gives: i for i, piece in enumerate(pieces) for line in piece}
    slots: dict[int, int] = {}
    for i, piece in enumerate(pieces):
        for line in piece:
            for value in line.takes:
                if made[value] != i:
                    slots.setdefault(value, len(slots))
    texts = []
    for i, piece in enumerate(pieces):
        body: list[str] = []
        loaded: set[int] = set()
        for line in piece:
            for value in line.takes:
                if made[value] != i and value not in loaded:
                    loaded.add(value)
                    body.append(f"real v{value}=w[{slots[value]}];")
            body.append(line.text)
            if line.gives in slots:
                body.append(f"w[{slots[line.gives]}]=v{line.gives};")
        texts.append(
            f"static __attribute__((noinline)) void {name}_{i}(const real *restrict z, "
            "const real *restrict p, const real *restrict s, real f, const real *restrict l, "
            "real *restrict out, real *restrict w) {\n" + "\n".join(body) + "\n}\n"
        )
    return texts, len(slots)


@dataclass(frozen=True)
class _Line:
    """A statement; which values it takes, and which one it gives (of an output, none's number)."""

    text: str
    takes: tuple[int, ...]
    gives: int


class _Reader:
    """Reads CasADi's instructions, whose places are used again, as values each assigned once."""

    def __init__(self, function: ca.Function) -> None:
        self._function = function
        self._offset = [0]
        for j in range(function.n_out()):
            self._offset.append(self._offset[-1] + function.numel_out(j))

    def lines(self) -> Iterator[_Line]:
        """Statements, in order."""
        function = self._function
        holds: dict[int, tuple[str, tuple[int, ...]]] = {}  # place -> text, value
        given: set[int] = set()
        for k in range(function.n_instructions()):
            operation = function.instruction_id(k)
            take, give = function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_INPUT:
                # Scalar arguments come by value.
                name = "zpsfl"[take[0]]
                holds[give[0]] = (name if name == "f" else f"{name}[{take[1]}]"), ()
                continue
            if operation == ca.OP_CONST:
                holds[give[0]] = _number(function.instruction_constant(k)), ()
                continue
            texts, values = zip(*(holds[place] for place in take), strict=True)
            takes = tuple(value for found in values for value in found)
            if operation == ca.OP_OUTPUT:
                at = self._offset[give[0]] + give[1]
                given.add(at)
                yield _Line(f"out[{at}]=(real){{0}}+{texts[0]};", takes, -1 - at)
                continue
            if operation in _BINARY:
                text = _BINARY[operation].format(*texts)
            elif operation in _UNARY:
                text = _UNARY[operation].format(texts[0])
            else:
                raise NotInC(
                    f"{function.name()}: operation {operation} is not written as C; expected one "
                    "of sums, products, quotients, roots, sines, cosines and atan2"
                )
            holds[give[0]] = f"v{k}", (k,)
            yield _Line(f"real v{k}={text};", takes, k)
        for at in sorted({*range(self._offset[-1])} - given):
            yield _Line(f"out[{at}]=(real){{0}};", (), -1 - at)


def _number(value: float) -> str:
    if not math.isfinite(value):
        raise NotInC(f"the constant {value} is not written as C; expected a finite one")
    return f"({value!r})"


def _table(declaration: str, values: Iterable[int]) -> str:
    numbers = [*values] or [0]  # C has no empty arrays
    return f"{declaration}[] = {{{','.join(map(str, numbers))}}};\n"


# ---- the problem

_FUNCTION = """\
int {name}(const double **arg, double **res, long long *iw, double *w, int mem) {{
  w = (double *)(((unsigned long)w + 63) / 64 * 64);
{body}
  return 0;
}}
long long {name}_n_in(void) {{ return {n_in}; }}
long long {name}_n_out(void) {{ return {n_out}; }}
const char *{name}_name_in(long long i) {{
  static const char *const names[] = {{{names_in}}};
  return names[i];
}}
const char *{name}_name_out(long long i) {{
  static const char *const names[] = {{{names_out}}};
  return names[i];
}}
const long long *{name}_sparsity_in(long long i) {{
  static const long long *const all[] = {{{sparsity_in}}};
  return all[i];
}}
const long long *{name}_sparsity_out(long long i) {{
  static const long long *const all[] = {{{sparsity_out}}};
  return all[i];
}}
int {name}_work(long long *sz_arg, long long *sz_res, long long *sz_iw, long long *sz_w) {{
  long long most = 0;
{sizes}
  *sz_arg = {n_in}; *sz_res = {n_out}; *sz_iw = 0; *sz_w = most + 8;
  return 0;
}}
"""

_DECLARED = (
    "void {0}(const double *, const double *, double, const double *, double *const *, double *);\n"
    "int {0}_size(void);\n"
)

# Adds x_next to the rows of each gap.
_GAPS = """\
static void with_gaps(const double *x, double *g) {
  for (int k = 0; k < STAGES - 1; k++)
    for (int i = 0; i < gap[k]; i++) g[row_at[k] + i] += x[variable_at[k + 1] + i];
}
"""

# Function of the problem: kind of the stages' functions, and the results that it fills.
_PROBLEM = {
    "nlp_f": ("cost", "res[0]"),
    "nlp_grad_f": ("gradient", "res[0]"),
    "nlp_g": ("constraints", "res[0]"),
    "nlp_jac_g": ("jacobian", "res[0], res[1]"),
    "nlp_hess_l": ("hessian", "res[1]"),
}
# Functions that a library has.
EVALUATED = tuple(_PROBLEM)


def _problem(transcription: Transcription, families: list[_Family]) -> str:
    """The file that is about all stages."""
    starts = sorted(
        (variable, row, family.functions.gap)
        for family in families
        for variable, row in zip(family.variables, family.rows, strict=True)
    )
    variables, rows, gaps = zip(*starts, strict=True)
    parts = [f"#define STAGES {len(starts)}\n"]
    parts.append(_table("static const int variable_at", variables))
    parts.append(_table("static const int row_at", rows))
    parts.append(_table("static const int gap", gaps))
    parts.append(_GAPS)
    structure = transcription.structure
    for field in _STRUCTURE:
        parts.append(_table(f"const int structure_{field}", map(int, getattr(structure, field))))
        parts.append(f"const int structure_{field}_size = {len(getattr(structure, field))};\n")
    patterns: dict[str, str] = {}

    def pattern(sparsity: ca.Sparsity) -> str:
        numbers = [*sparsity.size(), *sparsity.colind(), *sparsity.row()]
        text = ",".join(map(str, numbers))
        return patterns.setdefault(text, f"pattern{len(patterns)}")

    functions = []
    for name, (kind, results) in _PROBLEM.items():
        function = transcription.functions[name]
        calls = [f"family{i}_{kind}" for i in range(len(families))]
        parts += [_DECLARED.format(call) for call in calls]
        lam = "*arg[2], arg[3]" if kind == "hessian" else "0, 0"
        body = [f"  double *const to[] = {{{results}}};"]
        if kind == "cost":
            body = ["  if (!res[0]) return 0;", *body, "  *res[0] = 0;"]
        body += [f"  {call}(arg[0], arg[1], {lam}, to, w);" for call in calls]
        if kind in ("constraints", "jacobian"):
            body.append("  if (res[0]) with_gaps(arg[0], res[0]);")
        n_in, n_out = function.n_in(), function.n_out()
        functions.append(
            _FUNCTION.format(
                name=name,
                body="\n".join(body),
                n_in=n_in,
                n_out=n_out,
                names_in=",".join(f'"{function.name_in(i)}"' for i in range(n_in)),
                names_out=",".join(f'"{function.name_out(i)}"' for i in range(n_out)),
                sparsity_in=",".join(pattern(function.sparsity_in(i)) for i in range(n_in)),
                sparsity_out=",".join(pattern(function.sparsity_out(i)) for i in range(n_out)),
                sizes="\n".join(
                    f"  if ({call}_size() > most) most = {call}_size();" for call in calls
                ),
            )
        )
    parts += [f"static const long long {name}[] = {{{text}}};\n" for text, name in patterns.items()]
    return "\n".join(parts + functions)


_STRUCTURE = tuple(Structure.__dataclass_fields__)
