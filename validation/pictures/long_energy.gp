# Energy over the long run: means of 35 s over the first of them, for three integrators, from
# long_windows.csv. A run that was lost leaves the picture. The key says after how many steps a run of
# imexv switched to the energy integrator, from long.csv.
# gnuplot -e "input='long_windows.csv'; runs='long.csv'; output_file='long_energy.png'" long_energy.gp
# SPDX-License-Identifier: Apache-2.0
set encoding utf8
set terminal pngcairo size 1260, 430 font 'DejaVu Sans,11' background '#ffffff'
set output output_file
set datafile separator ','
set border 3 lc rgb '#777777'
set tics nomirror
set grid y lc rgb '#e6e6e6' lt 1
set xlabel 'simulated time [s]'
set format y '%g'
set key at graph 0.98, graph 0.95 right top samplen 2 spacing 1.2

# the time and the energy of a row of one run, else nothing
is(m, i, a) = strcol('model') eq m && strcol('scheme') eq i && abs(column('amplitude') - a) < 1e-9
when(m, i, a) = is(m, i, a) ? column('begin_s') + 17.5 : NaN
first = NaN
energy(m, i, a) = (is(m, i, a) && column('window') == 0 ? first = column('total_j') : 0, \
  is(m, i, a) ? column('total_j') / first : NaN)

set multiplot layout 1, 2 margins 0.055, 0.985, 0.13, 0.88 spacing 0.06
do for [n = 1:2] {
  model = n == 1 ? 'horse' : 'beam'
  swing = n == 1 ? 0.05 : 0.1
  set title sprintf('%s, undamped, swinging by %g %% of its length', model, 100 * swing) \
    font 'DejaVu Sans,13' textcolor rgb '#333333'
  # when the Newmark run ended, beside the one that did not
  set xrange [*:*]
  set yrange [*:*]
  stats input using (when(model, 'newmark', swing)) nooutput name 'N'
  stats input using (when(model, 'energy', swing)) nooutput name 'E'
  unset label
  if (N_max < 0.9 * E_max) {
    set label sprintf('Newmark is lost within %.0f s', N_max + 17.5) at graph 0.03, 0.93 \
      textcolor rgb '#d2691e'
  }
  # how many steps of imexv were its own
  set xrange [*:*]
  stats runs using (is(model, 'imexv', swing) ? column('steps') - column('switched') : NaN) nooutput name 'I'
  imexv = sprintf('imexv: %.0f steps, then energy', I_max)
  set xrange [-0.012 * E_max:E_max + 17.5]
  set yrange [0.5:1.5]
  set ylabel (n == 1 ? 'energy / energy at the start' : '')
  plot input using (when(model, 'newmark', swing)):(energy(model, 'newmark', swing)) with lines \
      lw 1.8 lc rgb '#d2691e' title 'Newmark', \
    '' using (when(model, 'energy', swing)):(energy(model, 'energy', swing)) with lines \
      lw 6 lc rgb '#a8d5b8' title 'energy', \
    '' using (when(model, 'imexv', swing)):(energy(model, 'imexv', swing)) with lines \
      lw 2 lc rgb '#1769aa' title imexv
}
unset multiplot
