"""What ``spark-submit`` is given: :mod:`roadbench.spark` from a command line.

Example::

    spark-submit --master spark://host:7077 .../roadbench/submit.py /archive --out /tables
    spark-submit --master spark://host:7077 .../roadbench/submit.py s3://fleet/archive --out s3://fleet/tables
"""

import argparse
import json
import sys

from pyspark.sql import SparkSession

import roadbench.spark


def main(arguments: list[str] | None = None) -> int:
    """Exit codes as of ``roadbench run``: 1 where logs were rejected, 2 bad usage, 3 cannot write."""
    parser = argparse.ArgumentParser(description="roadbench run, on a Spark cluster")
    parser.add_argument("inputs", nargs="+", metavar="INPUT", help="logs, folders, archives, patterns")
    parser.add_argument("--bikes", metavar="DIR", help="folder of bike files; else beside the sessions")
    parser.add_argument("--out", metavar="DIR", required=True, help="folder of the tables")
    parser.add_argument("--pipeline", metavar="FILE", default="onroad", help="a built-in name or a file")
    parser.add_argument("--map", metavar="FILE", action="append", default=[], help="channel map")
    parser.add_argument("--force", action="store_true", help="compute again what is there already")
    parser.add_argument("--signals", action="store_true", help="also write the time series")
    parser.add_argument("--model", metavar="PATH", help="remove what a diagnosis identified: its output, or a model file")
    parser.add_argument("--diagnose", action="store_true", help="roadbench diagnose instead of run")
    parser.add_argument("--nulls", metavar="N", type=int, default=24, help="of --diagnose: simulated nulls")
    parser.add_argument("--batch", metavar="N", type=int, default=8, help="sessions in one task")
    given = parser.parse_args(arguments)
    spark = SparkSession.builder.appName("roadbench").getOrCreate()
    try:
        how = {"bikes": given.bikes, "pipeline": given.pipeline, "maps": given.map, "batch": given.batch}
        how["force"] = given.force
        if given.diagnose:
            done = roadbench.spark.diagnose(spark, given.inputs, given.out, **how, nulls=given.nulls)
        else:
            done = roadbench.spark.run(spark, given.inputs, given.out, **how, signals=given.signals, model=given.model)
    except ValueError as why:
        print(f"roadbench: {why}", file=sys.stderr)
        return 2
    except OSError as why:
        print(f"roadbench: {why}", file=sys.stderr)
        return 3
    finally:
        spark.stop()
    print(json.dumps({k: v for k, v in done.items() if k != "pipeline"}, indent=2))
    return 1 if done["rejected"] else 0


if __name__ == "__main__":
    sys.exit(main())
