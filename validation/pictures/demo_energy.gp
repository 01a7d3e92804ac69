# The energy of one struck beam over a minute, stepped by four integrators: above all of it, on a
# logarithmic axis because a lost run leaves every other scale; below the same curves within 20 % of
# what the strike gave, where the others can be told apart.
# gnuplot -e "folder='out'; output_file='energy.png'" demo_energy.gp
# SPDX-License-Identifier: Apache-2.0
set encoding utf8
set terminal pngcairo size 1000, 700 font 'DejaVu Sans,11' background '#ffffff'
set output output_file
set datafile separator ','
set border 3 lc rgb '#777777'
set tics nomirror
set grid y lc rgb '#e4e4e4'
set xrange [0 : 60]
set lmargin 10
set rmargin 3
energy(integrator) = sprintf('%s/%s/energy.csv', folder, integrator)

# what the strike gave: the energy integrator keeps it, so its least after the first row is that
stats energy('energy') using ($5 > 0 ? $5 : 1/0) nooutput
given = STATS_median

set multiplot
set size 1, 0.52
set origin 0, 0.48
set logscale y
set yrange [1 : *]
set format y '10^{%T}'
set ylabel 'energy [J]'
set title 'Energy of a beam struck once and left alone: 60 steps a second, swing 10 % of its length'
set key top left reverse Left samplen 2
plot energy('newmark') using 2:($5 > 0 ? $5 : 1/0) with lines lw 2 lc rgb '#d62728' title 'newmark', \
     energy('midpoint') using 2:($5 > 0 ? $5 : 1/0) with lines lw 2 dt (9,4) lc rgb '#9467bd' title 'midpoint', \
     energy('imexv') using 2:($5 > 0 ? $5 : 1/0) with lines lw 2 dt (3,3) lc rgb '#c25a00' \
       title 'imexv, which switches to the step of energy', \
     energy('energy') using 2:($5 > 0 ? $5 : 1/0) with lines lw 3 lc rgb '#1f77b4' title 'energy'

set size 1, 0.48
set origin 0, 0
unset logscale y
set yrange [0.8 * given : 1.2 * given]
set format y '%.2f'
set xlabel 'simulated time [s]'
set title 'the same within 20 % of the run by the integrator energy'
unset key
plot energy('newmark') using 2:($5 > 0 ? $5 : 1/0) with lines lw 1 lc rgb '#d62728', \
     energy('midpoint') using 2:($5 > 0 ? $5 : 1/0) with lines lw 1 dt (9,4) lc rgb '#9467bd', \
     energy('imexv') using 2:($5 > 0 ? $5 : 1/0) with lines lw 1.6 dt (3,3) lc rgb '#c25a00', \
     energy('energy') using 2:($5 > 0 ? $5 : 1/0) with lines lw 3 lc rgb '#1f77b4'
unset multiplot
