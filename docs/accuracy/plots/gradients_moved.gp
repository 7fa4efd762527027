# data: gradients_moved.csv
set title 'Predicted at 0.25 R from the record: alpha 0.3, order 10'
set xlabel 'bands with a gradient'
set ylabel 'RMS error / mean'
set xrange [-0.3:6.3]
set yrange [0:*]
# The columns of all places: the last four.
plot data.'/gradients_moved.csv' using 1:(100 * $14) skip 1 with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'first bands (ours)', \
    '' using 1:(100 * $15) skip 1 with linespoints lc rgb hue[6] lw 2 pt 7 ps 0.6 title 'fitted alone', \
    '' using 1:(100 * $16) skip 1 with linespoints lc rgb 'black' dt 3 pt 6 ps 0.6 title 'true, first bands', \
    '' using 1:(100 * $17) skip 1 with linespoints lc rgb hue[6] dt 3 pt 6 ps 0.6 title 'true, fitted alone'
