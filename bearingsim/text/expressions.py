"""Formulas in a study, such as `defect.width / 4` or `min(load, 200 N) * 2 < 300 N`.

They are parsed by Python's `ast` in eval mode but never executed: only the node types listed below are allowed,
and they are evaluated here, in SI. Quantities and paths such as `defects.2.width` are not valid Python, and are
replaced by names of the same length, so that the columns of errors are those of the text.
"""

import ast
import math
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from bearingsim.text import algebra
from bearingsim.text.algebra import BOOLEAN, DIMENSIONLESS, MAX_CHARACTERS, MAX_DEPTH, Kind, kind_text
from bearingsim.text.units import UnitError, parse, split, suggestion
from bearingsim.text.yamlfile import Mark, Node

MAX_EXPONENT = 10
"""Largest exponent of a quantity with a unit."""


class ExpressionError(Exception):
    """Error in a formula or its evaluation, with its position in the file and a remedy."""

    def __init__(self, mark: Mark, message: str, hint: str | None = None) -> None:
        self.mark, self.hint = mark, hint
        super().__init__(message)


_CELSIUS = ("C", "degC")
_SYNTAX_HINT = (
    "possible are numbers with their units, paths, `+ - * / **`, comparisons, `and`, `or`, `not`, and "
    + ", ".join(f"`{name}`" for name in (*algebra.FUNCTIONS, *algebra.CONSTANTS))
)
_UNITS = "|".join(re.escape(word) for word in sorted((*algebra.DIMENSIONS, "°"), key=len, reverse=True))
_QUANTITY_OR_PATH = re.compile(
    rf"(?<![\w.])(?P<quantity>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\d.]) *(?:{_UNITS})(?![\w.^]))"
    r"|(?<![\w.])(?P<path>[A-Za-z_]\w*(?:\.\w+)+)",
    re.ASCII,
)
_ASCII_SPELLING = str.maketrans({"µ": "u", "μ": "u", "\n": " "})


@dataclass(frozen=True)
class Expression:
    """Parsed formula: its syntax tree, and its quantities and paths by column."""

    node: Node
    tree: ast.expr
    quantities: dict[int, str]
    paths: dict[int, str]
    shift: int  # number of leading blanks

    def names(self) -> Iterator[tuple[str, Mark]]:
        """Yield the paths of the formula, with their positions."""
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Name) and not self._is_builtin(node):
                yield self._path(node), self._mark(node)

    def kind(self, path_kind: Callable[[str], Kind]) -> Kind:
        """Return the kind of the value; ``path_kind``: function that returns a path's kind, or raises ValueError.

        Raises ExpressionError for a node that is not allowed, and for incompatible units. Call before ``value``.
        """
        return self._kind(self.tree, path_kind, 0)

    def value(self, path_value: Callable[[str], float]) -> float:
        """Evaluate the formula in SI, a comparison to True or False; ``path_value``: function that returns the
        value of a path.

        Raises ExpressionError for a division by zero, a root of a negative number, or a result that is not finite.
        """
        return self._value(self.tree, path_value)

    # Kinds

    def _kind(self, node: ast.expr, path_kind: Callable[[str], Kind], depth: int) -> Kind:
        if depth > MAX_DEPTH:
            raise self._error(node, f"more than {MAX_DEPTH} nested levels")
        kinds = [self._kind(operand, path_kind, depth + 1) for operand in _operands(node)]
        match node:
            case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
                self._evaluate(node, lambda: float(number))
                return DIMENSIONLESS
            case ast.Name():
                return self._kind_of_name(node, path_kind)
            case ast.UnaryOp(op=op) if type(op) in algebra.SIGNS:
                return self._check_number(node.operand, kinds[0])
            case ast.UnaryOp(op=ast.Not()):
                return self._check_truth(node.operand, kinds[0])
            case ast.BinOp(op=op) if type(op) in algebra.BINARY:
                return self._kind_of_operation(node, *kinds)
            case ast.BoolOp():
                for operand, kind in zip(node.values, kinds, strict=True):
                    self._check_truth(operand, kind)
                return BOOLEAN
            case ast.Compare() if all(type(op) in algebra.COMPARISONS for op in node.ops):
                self._check_same_kind(_operands(node), kinds)
                self._reject_celsius_with_difference(_operands(node))
                return BOOLEAN
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in algebra.FUNCTIONS:
                return self._kind_of_call(node, algebra.FUNCTIONS[name], kinds)
            case ast.Call(func=ast.Name(id=name) as function) if name not in algebra.FUNCTIONS:
                raise self._error(
                    function, f"no function `{name}`", suggestion(name, algebra.FUNCTIONS) or _SYNTAX_HINT
                )
        raise self._error(node, "not allowed in a formula", _SYNTAX_HINT)

    def _kind_of_name(self, node: ast.Name, path_kind: Callable[[str], Kind]) -> Kind:
        if node.id in algebra.CONSTANTS:
            return DIMENSIONLESS
        if node.col_offset in self.quantities:
            return self._kind_of_quantity(node, self.quantities[node.col_offset])
        if node.id in algebra.FUNCTIONS:
            raise self._error(node, f"`{node.id}` has no argument", f"as in `{node.id}(...)`")
        try:
            return path_kind(self._path(node))
        except ValueError as error:
            raise self._error(node, str(error)) from None

    def _kind_of_quantity(self, node: ast.Name, text: str) -> Kind:
        try:
            parse(text, algebra.dimension(text))
        except UnitError as error:
            raise self._error(node, error.hint or str(error)) from None
        return algebra.KINDS[algebra.dimension(text)]

    def _kind_of_operation(self, node: ast.BinOp, left: Kind, right: Kind) -> Kind:
        self._check_number(node.left, left)
        self._check_number(node.right, right)
        if type(node.op) in algebra.SUMS:
            self._check_same_kind([node.left, node.right], [left, right])
        self._reject_celsius(
            f"{algebra.OPERATION_NAMES[type(node.op)]} with degrees Celsius", node.left, node.right
        )
        if type(node.op) in algebra.SUMS:
            return left
        if isinstance(node.op, ast.Pow):
            return self._kind_of_power(node, left, right)
        sign = 1 if isinstance(node.op, ast.Mult) else -1
        return tuple(a + sign * b for a, b in zip(left, right, strict=True))

    def _kind_of_power(self, node: ast.BinOp, base: Kind, exponent: Kind) -> Kind:
        if exponent != DIMENSIONLESS:
            raise self._error(node.right, f"an exponent is a plain number, got {kind_text(exponent)}")
        self._check_brackets(node)
        if base == DIMENSIONLESS:
            return DIMENSIONLESS
        if any(isinstance(operand, ast.Name) for operand in ast.walk(node.right)):
            raise self._error(node.right, f"the exponent of {kind_text(base)} must be written as a number")
        power = self._value(node.right, _reject_path)
        if abs(power) > MAX_EXPONENT:
            raise self._error(node.right, f"the exponent of {kind_text(base)} is at most {MAX_EXPONENT}")
        return algebra.power_kind(base, Fraction(power).limit_denominator(1000))

    def _check_brackets(self, node: ast.BinOp) -> None:
        """Reject a power of a quantity without brackets, because `3 mm**2` may mean 9 mm^2 or 3 mm^2."""
        base, exponent = node.left, node.right
        if not isinstance(base, ast.Name) or base.col_offset not in self.quantities:
            return
        if self.node.text[self.shift + (base.end_col_offset or 0) :].lstrip().startswith("**"):
            quantity = self.quantities[base.col_offset]
            number, unit = split(quantity)
            power = ast.unparse(exponent) if isinstance(exponent, ast.Constant) else "(...)"
            is_unit = f"{unit}^{power}" in algebra.DIMENSIONS
            alternative = f"{number} {unit}^{power}" if is_unit else f"{number} * (1 {unit})**{power}"
            raise self._error(
                node,
                f"a power of `{quantity}` without brackets",
                f"write `({quantity})**{power}` or `{alternative}`",
            )

    def _kind_of_call(self, node: ast.Call, function: algebra.Function, kinds: list[Kind]) -> Kind:
        if not function.min_arguments <= len(kinds) <= function.max_arguments:
            count = "one value" if function.max_arguments == 1 else "two values or more"
            raise self._error(node, f"expected {count}, got {len(kinds)}")
        for operand, kind in zip(node.args, kinds, strict=True):
            self._check_number(operand, kind)
        self._check_same_kind(node.args, kinds)
        if function.max_arguments == 1:
            self._reject_celsius("a function of degrees Celsius", *node.args)
        else:  # min and max return an argument unchanged
            self._reject_celsius_with_difference(node.args)
        return function.kind(kinds[0])

    def _reject_celsius(self, message: str, *nodes: ast.expr) -> None:
        """Reject degrees Celsius in arithmetic: 20 C + 10 C is neither 30 C nor 293.15 K + 283.15 K."""
        for node in nodes:
            if text := self._celsius(node):
                kelvins = f"{parse(text, 'temperature'):.12g} K"
                hint = f"write `{split(text)[0]} K` for a difference, `{kelvins}` for a temperature"
                raise self._error(node, message, hint)

    def _reject_celsius_with_difference(self, nodes: list[ast.expr]) -> None:
        """Reject degrees Celsius compared with a temperature difference, which has no offset."""
        if any(isinstance(operand, ast.Sub) for node in nodes for operand in ast.walk(node)):
            self._reject_celsius("degrees Celsius and a temperature difference", *nodes)

    def _check_number(self, node: ast.expr, kind: Kind) -> Kind:
        if kind == BOOLEAN:
            raise self._error(node, "expected a number, got true or false")
        return kind

    def _check_truth(self, node: ast.expr, kind: Kind) -> Kind:
        if kind != BOOLEAN:
            raise self._error(node, f"expected a comparison such as `load < 200 N`, got {kind_text(kind)}")
        return kind

    def _check_same_kind(self, nodes: list[ast.expr], kinds: list[Kind]) -> None:
        for node, kind in zip(nodes, kinds, strict=True):
            self._check_number(node, kind)
            if kind != kinds[0]:
                raise self._error(node, f"expected {kind_text(kinds[0])} as on the left, got {kind_text(kind)}")

    # Values

    def _value(self, node: ast.expr, path_value: Callable[[str], float]) -> float:
        match node:
            case ast.Constant(value=int() | float() as number):
                return float(number)
            case ast.Name():
                return self._value_of_name(node, path_value)
            case ast.UnaryOp(op=ast.Not()):
                return not self._value(node.operand, path_value)
            case ast.UnaryOp():
                if text := self._celsius(node):
                    return parse(text, "temperature")
                return algebra.SIGNS[type(node.op)](self._value(node.operand, path_value))
            case ast.BinOp():
                left, right = self._value(node.left, path_value), self._value(node.right, path_value)
                return self._evaluate(node, lambda: algebra.BINARY[type(node.op)](left, right))
            case ast.BoolOp(op=ast.And()):
                return all(self._value(operand, path_value) for operand in node.values)
            case ast.BoolOp():
                return any(self._value(operand, path_value) for operand in node.values)
            case ast.Compare():
                return self._compare(node, path_value)
            case ast.Call(func=ast.Name(id=name)):
                arguments = [self._value(operand, path_value) for operand in node.args]
                return self._evaluate(node, lambda: algebra.FUNCTIONS[name].call(*arguments))
        raise AssertionError("a node that `kind` rejects")

    def _value_of_name(self, node: ast.Name, path_value: Callable[[str], float]) -> float:
        if node.id in algebra.CONSTANTS:
            return algebra.CONSTANTS[node.id]
        if node.col_offset in self.quantities:
            text = self.quantities[node.col_offset]
            return parse(text, algebra.dimension(text))
        try:
            return path_value(self._path(node))
        except ValueError as error:
            raise self._error(node, str(error)) from None

    def _compare(self, node: ast.Compare, path_value: Callable[[str], float]) -> bool:
        """Evaluate a chain of comparisons as Python does, up to the first false one."""
        left = self._value(node.left, path_value)
        for op, operand in zip(node.ops, node.comparators, strict=True):
            right = self._value(operand, path_value)
            if not algebra.COMPARISONS[type(op)](left, right):
                return False
            left = right
        return True

    def _evaluate(self, node: ast.expr, evaluate: Callable[[], float]) -> float:
        try:
            value = evaluate()
        except ZeroDivisionError:
            raise self._error(node, "a division by zero") from None
        except OverflowError:
            raise self._error(node, "the number is too large") from None
        except ValueError:
            raise self._error(node, "a root of less than zero") from None
        if isinstance(value, complex):
            raise self._error(node, "a root of less than zero")
        if not math.isfinite(value):
            raise self._error(node, "the number is too large")
        return value

    # Positions

    def _is_builtin(self, node: ast.Name) -> bool:
        """Check if a name is not a path of the study."""
        return node.id in algebra.CONSTANTS or node.id in algebra.FUNCTIONS or node.col_offset in self.quantities

    def _celsius(self, node: ast.expr) -> str | None:
        """Return a quantity in degrees Celsius with its sign, because `-5 C` is not -278.15 K; None for others."""
        match node:
            case ast.UnaryOp(op=ast.UAdd()):
                return self._celsius(node.operand)
            case ast.UnaryOp(op=ast.USub()):
                text = self._celsius(node.operand)
                return text and (text[1:] if text.startswith("-") else f"-{text}")
            case ast.Name():
                text = self.quantities.get(node.col_offset)
                return text if text and split(text)[1] in _CELSIUS else None
        return None

    def _path(self, node: ast.Name) -> str:
        return self.paths.get(node.col_offset, node.id)

    def _mark(self, node: ast.expr) -> Mark:
        column = self.shift + node.col_offset
        if isinstance(node, ast.BinOp):  # at its operator
            column = self.shift + (node.left.end_col_offset or 0)
            remainder = self.node.text[column:]
            column += len(remainder) - len(remainder.lstrip(" )"))
        return _mark_at(self.node, column)

    def _error(self, node: ast.expr, message: str, hint: str | None = None) -> ExpressionError:
        return ExpressionError(self._mark(node), message, hint)


def read(node: Node) -> Expression:
    """Parse a scalar of a file as a formula. Raises ExpressionError if it is not a formula."""
    if not isinstance(node.value, str) or not node.value.strip():
        raise ExpressionError(node.mark, "expected a formula such as `defect.width / 4`")
    if len(node.value) > MAX_CHARACTERS:
        raise ExpressionError(node.mark, f"more than {MAX_CHARACTERS} characters in a formula")
    text = node.value.translate(_ASCII_SPELLING)
    shift = len(text) - len(text.lstrip())
    quantities: dict[int, str] = {}
    paths: dict[int, str] = {}

    def substitute(match: re.Match[str]) -> str:
        texts = quantities if match["quantity"] else paths
        texts[match.start()] = match.group()
        return "_" * len(match.group())

    source = _QUANTITY_OR_PATH.sub(substitute, text.strip())
    invalid = next((column for column, letter in enumerate(source) if not letter.isascii()), None)
    if invalid is not None:
        message = f"a character that is not allowed in formulas: {source[invalid]!a}"
        raise ExpressionError(_mark_at(node, shift + invalid), message)
    return Expression(node, _parse_tree(node, source, shift), quantities, paths, shift)


def _parse_tree(node: Node, source: str, shift: int) -> ast.expr:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about syntax rejected later, such as `1if`
            return ast.parse(source, mode="eval").body
    except SyntaxError as error:
        column = min(error.offset or len(source), len(source)) - 1  # no offset at an unexpected end
        hint = "a quantity is written as in `3 mm`; quote a formula with a comma"
        raise ExpressionError(_mark_at(node, shift + column), "not a valid formula", hint) from None
    except (ValueError, MemoryError, RecursionError):
        raise ExpressionError(node.mark, "not a valid formula") from None


def _operands(node: ast.expr) -> list[ast.expr]:
    """List the operands of a node, from left to right."""
    match node:
        case ast.UnaryOp():
            return [node.operand]
        case ast.BinOp():
            return [node.left, node.right]
        case ast.BoolOp():
            return node.values
        case ast.Compare():
            return [node.left, *node.comparators]
        case ast.Call(func=ast.Name()):
            return node.args
    return []


def _reject_path(path: str) -> float:
    raise AssertionError(f"a constant has no path `{path}`")


def _mark_at(node: Node, column: int) -> Mark:
    """Return the position of a character of a scalar; that of the scalar if its text is not contiguous."""
    mark = node.mark
    for quote in (0, 1):
        start = mark.column - 1 + quote
        if mark.source_line[start : start + len(node.text)] == node.text:
            return replace(mark, column=start + column + 1)
    return mark
