# The comments of the headers are plain text: this turns them into documentation for doxygen (docs/Doxyfile), and
# escapes what it would take for its own commands or for HTML.
/^[[:space:]]*\/\/ SPDX/s/.*//
/^[[:space:]]*\/\/( |$)/ {
  s/[\\@<>&#%]/\\&/g
  # A long indent: the comment behind a member goes on.
  s/^([[:space:]]{12,})\/\/( |$)/\1\/\/\/< /
  s/^([[:space:]]*)\/\/( |$)/\1\/\/\/ /
  b
}
: trailing
/^[^"]*[;,{}][[:space:]]+\/\/ / {
  h
  s/^(.*[;,{}])[[:space:]]+\/\/ .*$/\1/
  x
  s/^.*[;,{}][[:space:]]+\/\/ (.*)$/\1/
  s/[\\@<>&#%]/\\&/g
  s/^/  \/\/\/< /
  x
  G
  s/\n//
}
