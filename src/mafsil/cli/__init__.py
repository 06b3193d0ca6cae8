"""The commands of `mafsil`: one module a command, in the table of `main`.

call      mafsil COMMAND --help
computed  `main` holds the table of commands, `registry` their options; a module a command; `answer` is what each
          returns, `table` prints
tested    tests/cli
"""

__all__ = ()
