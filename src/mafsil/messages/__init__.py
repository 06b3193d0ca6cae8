"""The message catalogue: every sentence that a user reads, in English and Arabic."""

from mafsil.messages.catalogue import LANGUAGES as LANGUAGES
from mafsil.messages.catalogue import clauses as clauses
from mafsil.messages.catalogue import direction as direction
from mafsil.messages.catalogue import keys as keys
from mafsil.messages.catalogue import language as language
from mafsil.messages.catalogue import say as say
from mafsil.messages.catalogue import template as template
from mafsil.messages.isolates import in_cell as in_cell
from mafsil.messages.isolates import in_line as in_line
from mafsil.messages.isolates import in_sentence as in_sentence
