from mafsil.model.table.reading import parse as parse
from mafsil.model.table.reading import read as read
from mafsil.model.table.writing import format_table as format_table
from mafsil.model.table.writing import write as write
