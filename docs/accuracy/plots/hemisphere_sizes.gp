# data: hemisphere_sizes.csv
set terminal svg size 760,420 font 'sans-serif,13' background '#ffffff'
set multiplot layout 1, 2 margins 0.09, 0.98, 0.36, 0.9 spacing 0.08
set key at screen 0.5, 0.11 center vertical maxrows 3
set logscale xy
set xlabel 'rays a record'
set ylabel 'RMS error / mean'
set format x '%g'
set xrange [200:60000]
set yrange [0.5:100]
rows(kind, way, extent) = "< awk -F, '$1 == \"".kind."\" && $2 == \"".way."\" && $3 == ".extent." { print $5 \",\" 100 * $6 \",\" 100 * $8 }' ".data.'/hemisphere_sizes.csv'
do for [column = 2:3] {
    set title column == 2 ? 'irradiance' : 'lobe of alpha 0.3, view of 75 degrees'
    plot rows('plane', 'middles', '3') using 1:column with linespoints lc rgb hue[1] pt 7 ps 0.6 title 'plane, h = 3', \
        rows('larsen', 'middles', '3') using 1:column with linespoints lc rgb hue[2] pt 7 ps 0.6 title 'larsen, h = 3', \
        rows('border', 'middles', '2') using 1:column with linespoints lc rgb hue[3] dt 2 pt 7 ps 0.6 title 'border, h = 2', \
        rows('border', 'middles', '3') using 1:column with linespoints lc rgb hue[3] pt 7 ps 0.6 title 'border, h = 3', \
        rows('hemicube', 'middles', '1') using 1:column with linespoints lc rgb hue[5] pt 7 ps 0.6 title 'hemicube, middles', \
        rows('hemicube', 'random', '1') using 1:column with linespoints lc rgb hue[6] pt 7 ps 0.6 title 'hemicube, random', \
        rows('hemicube', 'gather', '1') using 1:column with linespoints lc rgb 'black' lw 2 pt 7 ps 0.6 title 'the gather'
    unset ylabel
    unset key
}
unset multiplot
