#!/bin/bash
# VPL runs this to prepare an evaluation; it then runs vpl_execution, which prints the comments and the grade.
cat > vpl_execution <<'END'
#!/bin/bash
. ./vpl_environment.sh
exercise=$(head -n 1 exercise.txt)
own=$PWD/$exercise.yaml
program=
for kind in launch py bash; do
  program=${program:-$(find "$PWD" -name "$exercise.$kind" | sort | head -n 1)}
done
[ ! -f "$own" ] || exercise=$own
. "${TURTLE_ROBOTONT_WS:-/opt/turtle_robotont_ws}/env.bash"
exec rosrun turtle_robotont grade.py "$exercise" --format=vpl --output="$PWD/grades" \
  -- "${program:-$(basename "$exercise" .yaml).py}"
END
chmod +x vpl_execution
