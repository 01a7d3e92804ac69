# A file as a C array: cmake -DFILE=beam.npz -DHEADER=model_bytes.h -P bytes.cmake
# SPDX-License-Identifier: Apache-2.0
file(READ ${FILE} hex HEX)
string(REGEX REPLACE "(................................)" "\\1\n" hex "${hex}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," hex "${hex}")
file(WRITE ${HEADER} "static const unsigned char model_bytes[] = {\n${hex}\n};\n")
