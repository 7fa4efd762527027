# data: sh_tilts.csv
set title 'Tilted pixels: alpha 0.3, order 8, views of 10 and 40 degrees'
set xlabel 'tilt, degrees'
set ylabel 'RMS error / mean'
set logscale y
set yrange [0.5:40]
set xrange [-1:28]
# Columns: 2 + the index of the projection in allProjections().
plot data.'/sh_tilts.csv' using 1:(100 * $2) skip 1 with linespoints lc rgb hue[1] pt 7 ps 0.6 title 'zero below', \
    '' using 1:(100 * $3) skip 1 with linespoints lc rgb hue[2] pt 7 ps 0.6 title 'even reflection', \
    '' using 1:(100 * $4) skip 1 with linespoints lc rgb hue[6] pt 7 ps 0.6 title 'least squares', \
    '' using 1:(100 * $5) skip 1 with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'with a band (ours)', \
    '' using 1:(100 * $9) skip 1 with linespoints lc rgb hue[4] pt 7 ps 0.6 title 'to -15, weight 0.3', \
    '' using 1:(100 * $16) skip 1 with linespoints lc rgb hue[5] pt 7 ps 0.6 title 'hemispherical'
