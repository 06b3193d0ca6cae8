from mafsil.book.entry import Fact as Fact
from mafsil.book.entry import Slider as Slider
from mafsil.book.example import Example as Example
from mafsil.book.example import example as example
from mafsil.book.example import examples as examples
from mafsil.book.figure import Figure as Figure
from mafsil.book.figure import figure as figure
from mafsil.book.figure import figures as figures
