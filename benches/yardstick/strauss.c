#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
/* plain scalar C: strauss from N.L, R.V, alpha, gamma of each record, libm */
typedef struct { float N[3], L[3], R[3], V[3], alpha, gamma; } Rec;
static float F(float x){ const float kf=1.12f; return (powf(x-kf,-2)-powf(kf,-2))/(powf(1-kf,-2)-powf(kf,-2)); }
static float G(float x){ const float kg=1.01f; return (powf(1-kg,-2)-powf(x-kg,-2))/(powf(1-kg,-2)-powf(kg,-2)); }
static float dot(const float*a,const float*b){return a[0]*b[0]+a[1]*b[1]+a[2]*b[2];}
void shade(const Rec*r,int n,float s,float m,float t,const float*C,const float*IL,float*out){
 for(int i=0;i<n;i++){ const Rec*q=r+i;
  float a=q->alpha/(float)(M_PI/2), g=q->gamma/(float)(M_PI/2);
  float rd=(1-s*s*s)*(1-t), rn=(1-t)-rd, f=F(a), j=f*G(a)*G(g), rj=fminf(1,rn+(rn+0.1f)*j);
  float d=fmaxf(0,dot(q->N,q->L))*(1-m*s)*rd, h=powf(fmaxf(0,dot(q->R,q->V)),3/(1-s))*rj;
  for(int c=0;c<3;c++) out[3*i+c]+=IL[c]*(d*C[c]+h*(1+m*(1-f)*(C[c]-1)));
 }}
int main(){ int n=1<<16; Rec*r=malloc(n*sizeof*r); float*o=calloc(3*n,4); srand(1);
 #define U (rand()/(float)RAND_MAX*2-1)
 for(int i=0;i<n;i++){ float*v[3]={r[i].N,r[i].L,r[i].V}; for(int k=0;k<3;k++){float l; do{ for(int c=0;c<3;c++)v[k][c]=U; l=sqrtf(dot(v[k],v[k])); }while(l<0.1f||l>1|| (k&&dot(v[k],r[i].N)<=0)); for(int c=0;c<3;c++)v[k][c]/=l;}
  float d=dot(r[i].N,r[i].L); for(int c=0;c<3;c++)r[i].R[c]=2*d*r[i].N[c]-r[i].L[c]; r[i].alpha=acosf(d); r[i].gamma=acosf(dot(r[i].N,r[i].V)); }
 float C[3]={.8f,.3f,.2f},IL[3]={1,1,1}; double best=1e9; for(int k=0;k<20;k++){ struct timespec a,b; clock_gettime(CLOCK_MONOTONIC,&a); shade(r,n,0.6f+k*1e-3f,0.2f,0,C,IL,o); clock_gettime(CLOCK_MONOTONIC,&b); double e=(b.tv_sec-a.tv_sec)*1e9+(b.tv_nsec-a.tv_nsec); if(e<best)best=e; }
 printf("C -O2 libm: %.1f ns/record (%f)\n",best/n,o[5]); }
