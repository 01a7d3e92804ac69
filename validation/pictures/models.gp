# The six models under load: names and a scale around the picture that thrum_pictures drew.
# gnuplot -e "input='models.rgb'; output_file='models_under_load.png'" models.gp
# SPDX-License-Identifier: Apache-2.0
width = 1260
height = 760
foot = 70
set encoding utf8
set terminal pngcairo size width, height + foot font 'DejaVu Sans,11' background '#ffffff'
set output output_file
unset key
unset border
unset tics
unset colorbox
set lmargin 0
set rmargin 0
set tmargin 0
set bmargin 0
set xrange [0:width]
set yrange [-foot:height]
names = 'horse tower bridge basket heart beam'
do for [n = 0:5] {
  set label n + 1 word(names, n + 1) at (n % 3 + 0.5) * 420, height - (n / 3 + 1) * 380 + 4 \
    center font 'DejaVu Sans,13' textcolor '#333333' front
}
# the scale, in the colours of validation/pictures/render.c
set palette defined (0 '#4d80c7', 0.2 '#8ac4e6', 0.4 '#e6f2e6', 0.6 '#ffd98c', 0.8 '#f78c52', \
  1 '#cc2933')
set label 10 'at rest' at 455, -38 right textcolor '#555555'
set label 11 'largest displacement' at 805, -38 left textcolor '#555555'
set object 1 rectangle from 470, -46 to 790, -30 front fs empty border lc '#999999'
set cbrange [0:1]
set colorbox horizontal user origin 470.0 / width, 24.0 / (height + foot) \
  size 320.0 / width, 16.0 / (height + foot) noborder
set cbtics format ''
set cbtics scale 0
plot input binary array=(width, height) format='%uchar' flip=y using 1:2:3 with rgbimage, \
  NaN with points palette
