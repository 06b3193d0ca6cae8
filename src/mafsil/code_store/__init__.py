"""Compiled code on disk: which folder, that nobody else can write to it, and entries that are whole or absent."""

from mafsil.code_store.compilation import LOGGER as LOGGER
from mafsil.code_store.compilation import compilation as compilation
from mafsil.code_store.folder import CACHE_VARIABLE as CACHE_VARIABLE
from mafsil.code_store.folder import TEMPORARY as TEMPORARY
from mafsil.code_store.folder import code_folder as code_folder
from mafsil.code_store.folder import is_off as is_off
from mafsil.code_store.folder import prepare as prepare
from mafsil.code_store.folder import write_whole as write_whole
from mafsil.code_store.store import CacheWarning as CacheWarning
from mafsil.code_store.store import FileStore as FileStore
from mafsil.code_store.store import Kind as Kind
from mafsil.code_store.store import warn as warn
