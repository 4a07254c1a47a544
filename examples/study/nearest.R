# Nearest other person by group of photos. Usage: Rscript nearest.R results
folder <- commandArgs(trailingOnly = TRUE)[1]
people <- read.csv(file.path(folder, "people.csv"))
photos <- read.csv(file.path(folder, "photos.csv"))
people <- merge(people, photos[, c("photo", "focal_assumed")])
nearest <- aggregate(nearest_m ~ photo, people, median)
nearest$group <- dirname(nearest$photo)
print(aggregate(nearest_m ~ group, nearest, function(x) round(c(n = length(x), median = median(x)), 2)))
if (length(unique(nearest$group)) == 2) print(wilcox.test(nearest_m ~ group, nearest, exact = FALSE))
