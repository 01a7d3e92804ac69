# Writes the bytes of the file IN as the initialiser of a C array into OUT: cmake -DIN=… -DOUT=… -P text_as_c.cmake
# SPDX-License-Identifier: Apache-2.0
file(READ ${IN} bytes HEX)
string(REPEAT "." 32 line)
string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUT} "${bytes}\n")
