# Prepares the public headers for Doxygen (docs/Doxyfile.in): marks their plain comments, and gives each
# definition of the list macro X a name of its own, for Doxygen takes the first one of a name for all.
# SPDX-License-Identifier: Apache-2.0

FNR == 1 {
  header = FILENAME
  gsub(/.*\/|\.h$/, "", header)
}

# from its definition on, X is X_header_number; excluded by EXCLUDE_SYMBOLS
/^#define X\(/ { number++; defined = 1 }
defined {
  name = "X_" header "_" number
  sub(/^#define X\(/, "#define " name "(")
  sub(/\(X\)/, "(" name ")")
  if (sub(/^#undef X$/, "#undef " name)) defined = 0
}

# "::" within a DOI is no link
{ sub(/1295::AID/, "1295\\::AID") }

# the comment at the top of a file describes the file
FNR == 1 { sub(/^\/\* /, "/** \\file\n * ") }

# a comment behind a field, an enumerator or a declaration describes what stands before it
/[;,{)0-9] *\/\* / { sub(/ *\/\* /, " /**< ") }

# a comment on lines of its own describes what follows, unless it is a ruler between sections
/^ *\/\* / && !/^ *\/\* ---/ { sub(/\/\* /, "/** ") }

{ print }
