"""Options that several queries take as ``**options``, shown in the signature of each."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])


def shows_options(options: Any, arguments: Any) -> Callable[[Function], Function]:
    """Show options in the signature of a query that takes them as ``**options``, and refuse others.

    Parameters
    ----------
    options : TypedDict
        What type checkers and editors read.
    arguments : dataclass
        Has the defaults of the options.
    """

    def shows(query: Function) -> Function:
        signature = inspect.signature(query)
        own = [parameter for parameter in signature.parameters.values() if parameter.kind != parameter.VAR_KEYWORD]
        shared = [
            inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
            for field in fields(arguments)
            if field.name in options.__annotations__
        ]
        shown = sorted([*shared, *own], key=lambda parameter: parameter.kind)
        known = {parameter.name for parameter in shown}

        @functools.wraps(query)
        def checked(*positional: Any, **given: Any) -> Any:
            if unknown := given.keys() - known:
                raise TypeError(f"{query.__name__}() got an unexpected keyword argument {min(unknown)!r}")
            return query(*positional, **given)

        checked.__dict__["__signature__"] = signature.replace(parameters=shown)
        return cast(Function, checked)

    return shows
