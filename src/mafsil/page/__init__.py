"""One page that runs a robot in a browser: its kernels as WebAssembly, everything that is done as lines of Python."""

from mafsil.page.session import Session as Session
from mafsil.page.show import Page as Page
from mafsil.page.show import show as show
