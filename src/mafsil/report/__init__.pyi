from mafsil.report.comparison import Change as Change
from mafsil.report.comparison import ResultsComparison as ResultsComparison
from mafsil.report.comparison import compare_results as compare_results
from mafsil.report.law_report import write_law_report as write_law_report
from mafsil.report.results import write_results as write_results
