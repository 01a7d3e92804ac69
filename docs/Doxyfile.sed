# Marks the plain comments of the public headers for Doxygen (docs/Doxyfile.in).
# "::" within a DOI is no link
s/<\([0-9]*\)::/<\1\\::/
# the comment at the top of a file describes the file
1s|^/\* |/** \\file\n * |
# a comment behind a field, an enumerator or a declaration describes what stands before it
s|\([;,{)0-9]\) */\* \(.*\)$|\1 /**< \2|
# a comment on lines of its own describes what follows
s|^\( *\)/\* |\1/** |
