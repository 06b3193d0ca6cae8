from mafsil.job.judging.judgement import judge_run as judge_run
from mafsil.job.judging.judgement import summary as summary
